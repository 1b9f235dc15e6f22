"""Prints the wheel tag, which names the build folder in pyproject.toml."""

import sys
import sysconfig

python = f"cp{sys.version_info.major}{sys.version_info.minor}"
print(f"{python}-{python}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}")
