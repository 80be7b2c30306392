"""What the derivation hands on: names made from places, and every quantity a named assignment."""
