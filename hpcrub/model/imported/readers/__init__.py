"""Files of finite-element programs to the arrays of a model file, one module for each program."""
