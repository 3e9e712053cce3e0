"""F(y, p) and its Jacobian as the core calls them: sm_curve_rates."""

import ctypes

DOUBLES = ctypes.POINTER(ctypes.c_double)
RATES = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, DOUBLES, DOUBLES, DOUBLES)
