"""The scene: which chain, with which parameters, and which functions of it are wanted."""

from phichain.contract.functions import FUNCTIONS, PLANAR_FUNCTIONS, SPATIAL_FUNCTIONS
from phichain.scene.load import given_scene, load_scene, scene_from_dict, standard_scene
from phichain.scene.scene import Scene

__all__ = [
    "FUNCTIONS",
    "PLANAR_FUNCTIONS",
    "SPATIAL_FUNCTIONS",
    "Scene",
    "given_scene",
    "load_scene",
    "scene_from_dict",
    "standard_scene",
]
