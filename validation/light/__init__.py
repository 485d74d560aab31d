"""Light and shadow: the mesh, edges, several bounces."""
