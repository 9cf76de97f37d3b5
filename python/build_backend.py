"""Builds the wheel with CMake, and needs nothing else: pip install . works without a network.

The hooks of PEP 517. The libraries that Credence is built with come from the system (.ci/setup).
"""

import base64
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile

ROOT = pathlib.Path(__file__).resolve().parent.parent


def _metadata():
    project = (ROOT / "pyproject.toml").read_text()
    keys = ("name", "version", "description")
    name, version, summary = (re.search(rf'^{key} = "(.*)"', project, re.M)[1] for key in keys)
    text = f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\nSummary: {summary}\nRequires-Dist: numpy\n"
    return name, version, text


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    """What is known before anything is compiled: without it pip builds the wheel to read it."""
    name, version, metadata = _metadata()
    info = f"{name}-{version}.dist-info"
    folder = pathlib.Path(metadata_directory) / info
    folder.mkdir()
    (folder / "METADATA").write_text(metadata)
    return info


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    name, version, metadata = _metadata()
    abi = f"cp{sys.version_info.major}{sys.version_info.minor}"
    tag = f"{abi}-{abi}-{re.sub('[-.]', '_', sysconfig.get_platform())}"
    build = ROOT / "build" / f"wheel-{abi}"
    with tempfile.TemporaryDirectory() as prefix:
        options = [
            "-DCMAKE_BUILD_TYPE=Release",
            f"-DPython_EXECUTABLE={sys.executable}",
            "-DCREDENCE_PYTHON=ON",
            "-DCREDENCE_PYTHON_DIR=.",
            "-DCREDENCE_BUILD_TESTS=OFF",
            "-DCREDENCE_BUILD_BENCHMARKS=OFF",
        ]
        environment = dict(os.environ)
        if "CXX" not in environment and shutil.which("clang++"):
            environment["CXX"] = "clang++"  # half the time, as in .ci/build
        subprocess.run(["cmake", "-S", ROOT, "-B", build, "-G", "Ninja", *options], check=True, env=environment)
        subprocess.run(["cmake", "--build", build, "--target", "credence_python"], check=True)
        subprocess.run(["cmake", "--install", build, "--prefix", prefix, "--component", "python"], check=True)
        files = {
            str(path.relative_to(prefix)): path.read_bytes()
            for path in sorted(pathlib.Path(prefix).rglob("*"))
            if path.is_file()
        }
    info = f"{name}-{version}.dist-info"
    files[f"{info}/METADATA"] = metadata.encode()
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: credence\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    record = ""
    for path, content in files.items():
        digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b"=").decode()
        record += f"{path},sha256={digest},{len(content)}\n"
    files[f"{info}/RECORD"] = f"{record}{info}/RECORD,,\n".encode()
    wheel = f"{name}-{version}-{tag}.whl"
    with zipfile.ZipFile(pathlib.Path(wheel_directory) / wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for path, content in files.items():
            archive.writestr(path, content)
    return wheel


def build_sdist(sdist_directory, config_settings=None):
    raise RuntimeError("a source archive is what git makes: git archive --prefix=credence/ HEAD")
