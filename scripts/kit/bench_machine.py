"""What machine this is and which versions were measured. Standard library only, Linux."""

import importlib.metadata
import os
import platform
import re
import subprocess
from pathlib import Path

from kit.bench_peers import PEERS
from kit.program import PROJECT

FLAGS = ("sse4_2", "avx", "avx2", "bmi2", "avx512f", "avx512bw", "avx512vbmi", "avx512_vpopcntdq")
"""What the kernels ask for."""

BUSY = 0.5
"""Load per core above which figures mean little."""


def facts() -> dict[str, object]:
    """The machine as its kernel describes it."""
    first = read("/proc/cpuinfo").split("\n\n")[0]
    cpu = dict(re.findall(r"^(.+?)\s*: ?(.*)$", first, re.MULTILINE))
    flags = cpu.get("flags", "").split()
    memory = re.search(r"MemTotal:\s+(\d+)", read("/proc/meminfo"))
    return {
        "cpu": cpu.get("model name", platform.machine()),
        "family": "/".join(cpu.get(key, "?") for key in ("cpu family", "model", "stepping")),
        "cores": os.cpu_count(),
        "simd": [flag for flag in FLAGS if flag in flags],
        "flags": flags,
        "hypervisor": "hypervisor" in flags,
        "caches": caches(),
        "memory_gib": round(int(memory[1]) / 2**20, 1) if memory else None,
        "kernel": platform.release(),
        "libc": " ".join(platform.libc_ver()),
        "huge_pages": read("/sys/kernel/mm/transparent_hugepage/enabled").strip(),
    }


def caches() -> dict[str, str]:
    """The sizes of the first core's caches."""
    found = {}
    for index in sorted(Path("/sys/devices/system/cpu/cpu0/cache").glob("index*")):
        level, kind = read(index / "level").strip(), read(index / "type").strip()
        letter = {"Data": "d", "Instruction": "i"}.get(kind, "")
        found[f"L{level}{letter}"] = read(index / "size").strip()
    return found


def versions() -> dict[str, str]:
    """isokit, the compiler, and every package."""
    lock = read(PROJECT / "Cargo.lock")
    found = {
        "isokit": words("git", "-C", PROJECT, "describe", "--always", "--dirty", "--tags"),
        "rustc": words("rustc", "--version"),
        "python": platform.python_version(),
    }
    for name in ("fast-surface-nets", "isosurface"):
        version = re.search(rf'name = "{name}"\nversion = "(.+)"', lock)
        found[name] = version[1] if version else "absent"
    packages = {package for peer in PEERS.values() for package in peer.packages}
    for package in sorted(packages | {"numpy"}):
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            found[package] = "absent"
    return found


def absent(noted: Path) -> dict[str, str]:
    """The peers that are not installed, by the names of the table, with the reason."""
    lines = noted.read_text().splitlines() if noted.exists() else []
    reasons = dict(line.split(": ", 1) for line in lines if ": " in line)
    found = {}
    for name, peer in PEERS.items():
        for package in peer.packages:
            try:
                importlib.metadata.version(package)
            except importlib.metadata.PackageNotFoundError:
                found[name] = reasons.get(package, "not installed")
    return found


def load() -> float:
    """Processes that ran or waited in the last minute."""
    return os.getloadavg()[0]


def busy(load: float) -> str:
    """What is to be said of the load of the machine; nothing if it is fine."""
    cores = os.cpu_count() or 1
    if load <= BUSY * cores:
        return ""
    return f"The machine was busy: load {load:.2f} on {cores} cores. Do not quote these figures."


def short(cpu: str) -> str:
    """The name of a processor for the name of a folder."""
    plain = re.sub(r"\((r|tm)\)|@.*|\bcpu\b|\bprocessor\b", " ", cpu.lower())
    return re.sub(r"[^a-z0-9]+", "-", plain).strip("-") or "cpu"


def read(path: str | Path) -> str:
    """A file's text; empty if there is none."""
    try:
        return Path(path).read_text()
    except OSError:
        return ""


def words(*command: object) -> str:
    """What a command prints; empty if it cannot be run."""
    try:
        done = subprocess.run(
            list(map(str, command)), capture_output=True, text=True, check=False
        )
    except OSError:
        return ""
    return done.stdout.strip()
