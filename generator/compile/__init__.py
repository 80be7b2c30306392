"""From sources to an extension module: compilers, the processor they compile for, and what earlier builds have left."""
