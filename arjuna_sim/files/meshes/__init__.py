"""Meshes: STL, OBJ and COLLADA."""
