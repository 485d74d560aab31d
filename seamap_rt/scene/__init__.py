"""A scene: every section of one run, validated together.

Its sections, with the checks that need one of them alone, are in `seamap_rt.settings`, below the subpackages that take
them. The checks across sections stand in `agreement`: they need `radar`, `scattering` and the mesh's sizing, and so lie
above them: two subpackages on purpose. `python -m seamap_rt.scene.keys` writes the manual of all keys.
"""

from .model import Scene, SceneLike, anchored, as_scene, load_scene, scene_of, with_keys

__all__ = ["Scene", "SceneLike", "anchored", "as_scene", "load_scene", "scene_of", "with_keys"]
