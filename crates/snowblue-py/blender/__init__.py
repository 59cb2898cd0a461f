"""The extension for Blender. All of it is in the wheel."""

from snowblue.blender import register, unregister

__all__ = ["register", "unregister"]
