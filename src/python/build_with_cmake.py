"""What pip calls to build the package (pyproject.toml): setuptools, with the module made by CMake.

Settings, each given as `--config-settings NAME=VALUE`:

cmake-args   further arguments for cmake, separated by blanks
prefix       where ccvt is installed: the module is then linked with that, and only the module is
             compiled. Without it the library is compiled too, in build/python.
"""

import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys

import setuptools
from setuptools import build_meta
from setuptools.command.build_ext import build_ext
from setuptools.command.egg_info import manifest_maker

ROOT = pathlib.Path(__file__).resolve().parents[2]
SOURCES = "src/python"

manifest_maker.template = f"{SOURCES}/MANIFEST.in"  # what the archive of sources holds

_settings = {}


def version():
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    return re.search(r"project\(ccvt\s+VERSION ([0-9.]+)", text).group(1)


def parallel():
    """As many compilers at once as CMAKE_BUILD_PARALLEL_LEVEL says, which cmake reads, or as there
    are processors for this process."""
    if os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL"):
        return []
    if hasattr(os, "sched_getaffinity"):
        return ["--parallel", str(len(os.sched_getaffinity(0)))]
    return ["--parallel", str(os.cpu_count() or 1)]


class BuildWithCMake(build_ext):
    """Builds `ccvt._ccvt`, the one extension there is."""

    def build_extension(self, extension):
        module = pathlib.Path(self.get_ext_fullpath(extension.name)).resolve()
        prefix = _settings.get("prefix")
        build = ROOT / "build" / ("python-module" if prefix else "python")
        configure = [
            "cmake", "-S", ROOT / SOURCES if prefix else ROOT, "-B", build,
            f"-DPython_EXECUTABLE={sys.executable}", "-DCMAKE_BUILD_TYPE=Release",
        ]  # fmt: skip
        if prefix:
            # Not where an earlier call found it.
            configure += ["-U", "ccvt_DIR", f"-DCMAKE_PREFIX_PATH={pathlib.Path(prefix).resolve()}"]
        else:
            configure += ["-DCCVT_BUILD_PYTHON=ON", "-DCCVT_BUILD_CLI=OFF", "-DCCVT_BUILD_TESTS=OFF",
                          "-DCCVT_BUILD_BENCHMARKS=OFF"]  # fmt: skip
        if not (build / "CMakeCache.txt").exists():
            configure += ["-G", "Ninja"]
        self.run_cmake(configure + shlex.split(_settings.get("cmake-args", "")))
        self.run_cmake(["cmake", "--build", build, "--target", "ccvt_python", *parallel()])
        made = next(build.glob(f"**/package/ccvt/{module.name}"))
        module.parent.mkdir(parents=True, exist_ok=True)
        self.copy_file(str(made), str(module))

    @staticmethod
    def run_cmake(command):
        subprocess.run([str(word) for word in command], check=True)


class Backend(build_meta._BuildMetaBackend):
    """setuptools' backend, which calls setup() here instead of in a file setup.py."""

    def run_setup(self, setup_script="setup.py"):
        work = ROOT / "build" / "python-package"
        shutil.rmtree(work, ignore_errors=True)  # what an earlier package held
        work.mkdir(parents=True)
        setuptools.setup(
            version=version(),
            package_dir={"": SOURCES},
            packages=["ccvt"],
            package_data={"ccvt": ["py.typed", "*.pyi"]},
            ext_modules=[setuptools.Extension("ccvt._ccvt", [])],
            cmdclass={"build_ext": BuildWithCMake},
            options={"build": {"build_base": str(work)}, "egg_info": {"egg_base": str(work)}},
            zip_safe=False,
        )

    def build_wheel(self, wheel_directory, config_settings=None, metadata_directory=None):
        unknown = set(config_settings or {}) - {"cmake-args", "prefix"}
        if unknown:
            raise ValueError(
                f"config-settings: {', '.join(sorted(unknown))}: there are cmake-args and prefix"
            )
        _settings.update(config_settings or {})
        return super().build_wheel(wheel_directory, None, metadata_directory)


_backend = Backend()
get_requires_for_build_wheel = _backend.get_requires_for_build_wheel
get_requires_for_build_sdist = _backend.get_requires_for_build_sdist
prepare_metadata_for_build_wheel = _backend.prepare_metadata_for_build_wheel
build_wheel = _backend.build_wheel
build_sdist = _backend.build_sdist
