"""A driver in Python as a device of ``host-cli``: the crate ``haptic-bridge``."""

from fractional_haptics._native import Bridge

__all__ = ["Bridge"]
