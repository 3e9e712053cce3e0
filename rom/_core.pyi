"""The compiled core: an extension module without members, called through ctypes."""
