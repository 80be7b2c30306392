"""The derivation: kinematics, Gibbs function, recursion, closure, contacts."""
