"""All modules of both packages."""

import pkgutil

import npss
import npss_baselines

MODULES = sorted(
    module.name
    for package in (npss, npss_baselines)
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    if not module.name.endswith("__main__")
)
