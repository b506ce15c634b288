"""Builds the Python module `marco` by CMake: of an installed Marco where CMake finds one (CMAKE_PREFIX_PATH), else of the clone
around this folder, which takes about ten minutes. CMAKE_ARGS: more arguments of CMake."""
import os
import re
import shlex
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(HERE)


def version():
    """Of the clone; of this folder alone, what CMake says of the installed Marco is not known yet."""
    if not os.path.exists(ROOT + "/CMakeLists.txt"):
        return "0.1.0"
    with open(ROOT + "/CMakeLists.txt", encoding="utf-8") as file:
        return re.search(r"project\(marco VERSION ([\d.]+)", file.read())[1]


class CMakeBuild(build_ext):
    def build_extension(self, ext):
        out = os.path.dirname(os.path.abspath(self.get_ext_fullpath(ext.name)))
        build = os.path.abspath(self.build_temp)
        options = [f"-DPython3_EXECUTABLE={sys.executable}", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_UNITY_BUILD=ON",
                   f"-DMARCO_PYTHON_OUT={out}", *shlex.split(os.environ.get("CMAKE_ARGS", ""))]
        if shutil.which("ninja"):  # CMake's own choice is make, which Marco needs nowhere else
            options += ["-G", "Ninja"]
        alone = subprocess.run(["cmake", "-S", HERE, "-B", build + "/alone", *options], text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        print(alone.stdout)
        if alone.returncode == 0:
            build += "/alone"
        elif "Findmarco.cmake" in alone.stdout and os.path.exists(ROOT + "/CMakeLists.txt"):
            print("no installed Marco: the clone is built", file=sys.stderr)
            subprocess.run(["cmake", "-S", ROOT, "-B", build, "-DMARCO_PYTHON=ON", "-DMARCO_TESTS=OFF", *options], check=True)
        else:
            sys.exit("CMake cannot configure the module: see what it says above")
        subprocess.run(["cmake", "--build", build, "--target", "marco_python", "-j", str(os.cpu_count())], check=True)


setup(version=version(), packages=["marco"], package_data={"marco": ["*.pyi", "py.typed"]},
      ext_modules=[Extension("marco._marco", sources=[])], cmdclass={"build_ext": CMakeBuild})
