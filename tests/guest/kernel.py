# SPDX-License-Identifier: Apache-2.0
"""Debian's PREEMPT_RT kernel for the guest: fetched, unpacked into the cache, gpio-sim built beside it.

What is kept in ${SC_CACHE:-${XDG_CACHE_HOME:-~/.cache}/scribecell}/guest/VERSION is the kernel, the modules that the guest loads
and a static busybox, some 15 MB; the packages themselves are thrown away. Nothing is installed."""
import fcntl
import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

RECIPE = 1  # raised when what is kept, or how it is built, changes
# What the guest loads; what these need is found in the modules themselves.
MODULES = ("virtio_pci", "9pnet_virtio", "9p", "configfs", "can-raw", "can-dev", "vcan", "kvaser_pci", "hid-generic", "uhid",
           "sch_netem", "sch_tbf")
BOOT_MODULES = ("virtio_pci", "9pnet_virtio", "9p")
GPIO_SIM = "gpio-sim-guest"


class KernelError(Exception):
    """What is missing, in words that tell how to mend it."""


def cache_folder():
    base = os.environ.get("SC_CACHE") or Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "scribecell"
    folder = Path(base).resolve() / "guest"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def run(command, folder=None):
    done = subprocess.run([str(word) for word in command], cwd=folder, capture_output=True, text=True, check=False,
                          env={**os.environ, "LC_ALL": "C"})
    if done.returncode != 0:
        raise KernelError(f"this failed: {' '.join(map(str, command))}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def newest_known():
    """Name of the image package and its version, as apt's lists have them; None without lists."""
    done = subprocess.run(["apt-cache", "show", "--no-all-versions", "linux-image-rt-amd64"], capture_output=True, text=True,
                          check=False, env={**os.environ, "LC_ALL": "C"})
    found = re.search(r"^Depends:.*?\b(linux-image-(\S+?)-rt-amd64) \(= ([^)]+)\)", done.stdout, re.MULTILINE)
    return (found[1], found[2], found[3]) if found else None


def ready_folders():
    """Those in the cache that are whole, the newest first."""
    whole = [mark.parent for mark in cache_folder().glob(f"*/whole-{RECIPE}")]
    return sorted(whole, key=lambda folder: (folder / f"whole-{RECIPE}").stat().st_mtime, reverse=True)


def ready_kernel(say):
    """The folder of a kernel that is ready to boot. Fetches and builds it if there is none, or a newer one is known."""
    with open(cache_folder() / ".lock", "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        known = newest_known()
        if not known and not ready_folders() and os.geteuid() == 0:
            subprocess.run(["apt-get", "update", "-qq"], check=False)
            known = newest_known()
        ready = ready_folders()
        if known and cache_folder() / known[2] in ready:
            return cache_folder() / known[2]
        if not known:
            if ready:
                return ready[0]
            raise KernelError("apt does not know linux-image-rt-amd64; as root: apt-get update")
        try:
            return prepare_fresh(known, say)
        except KernelError as error:
            if not ready:
                raise
            say(f"the kernel {known[2]} cannot be had, so {ready[0].name} of the cache is taken: {error}")
            return ready[0]


def prepare_fresh(known, say):
    """A server keeps the newest version alone, so lists that are old name one that is gone."""
    try:
        return prepare(*known, say)
    except KernelError:
        if os.geteuid() != 0:
            raise
        subprocess.run(["apt-get", "update", "-qq"], check=False)
        newer = newest_known()
        if newer == known:
            raise
        return prepare(*newer, say)


def prepare(image, name, version, say):
    with tempfile.TemporaryDirectory(dir=cache_folder(), prefix=".new-") as temporary:
        work = Path(temporary)
        say(f"fetching Debian's kernel {version} with headers and source (220 MB), once")
        fetch(image, name, version, work)
        say("building gpio-sim for it")
        build_gpio_sim(work, name)
        kept = work / "kept"
        keep(work, name, kept)
        target = cache_folder() / version
        shutil.rmtree(target, ignore_errors=True)
        kept.rename(target)
    for old in cache_folder().iterdir():
        if old.is_dir() and old != target:
            shutil.rmtree(old, ignore_errors=True)
    return target


def fetch(image, name, version, work):
    packages = work / "packages"
    packages.mkdir()
    headers = [f"linux-headers-{name}-rt-amd64", f"linux-headers-{name}-common-rt", "linux-kbuild-6.1",
               "linux-compiler-gcc-12-x86", "linux-source-6.1"]
    run(["apt-get", "download", "-qq", *[f"{package}={version}" for package in [image, *headers]], "busybox-static"], packages)
    for package in sorted(packages.glob("*.deb")):
        run(["dpkg-deb", "-x", package, work / "root"])
        package.unlink()


def build_gpio_sim(work, name):
    """gpio-sim and the interrupts that it simulates as one module: Debian's kernel is built without both."""
    module, source = work / "module", work / "root/usr/src/linux-source-6.1.tar.xz"
    module.mkdir()
    top = "linux-source-6.1"
    run(["tar", "-xJf", source, "-C", module, "--strip-components=3", f"{top}/drivers/gpio/gpio-sim.c",
         f"{top}/drivers/gpio/gpiolib.h", f"{top}/kernel/irq/irq_sim.c"])
    irq_sim = module / "irq_sim.c"
    text = irq_sim.read_text(encoding="utf-8")
    # irq_to_desc is not there for modules; this call looks the descriptor up itself.
    text, changed = re.subn(r"handle_simple_irq\(irq_to_desc\((\w+)\)\)", r"generic_handle_irq_safe(\1)", text)
    if changed != 1:
        raise KernelError(f"{top}/kernel/irq/irq_sim.c is not as expected: {changed} calls of handle_simple_irq(irq_to_desc())")
    irq_sim.write_text(text, encoding="utf-8")
    (module / "Kbuild").write_text(f"obj-m := {GPIO_SIM}.o\n{GPIO_SIM}-y := gpio-sim.o irq_sim.o\n", encoding="utf-8")
    headers = work / f"root/usr/src/linux-headers-{name}-rt-amd64"
    makefile = headers / "Makefile"
    makefile.write_text(f"include {work}/root/usr/src/linux-headers-{name}-common-rt/Makefile\n", encoding="utf-8")
    run(["make", "-C", headers, f"M={module}", "modules"])


def needs(module):
    """What a module says it depends on."""
    found = re.search(rb"\0depends=([^\0]*)\0", module.read_bytes())
    return [word for word in found[1].decode().split(",") if word] if found else []


def load_order(by_name, wanted):
    """The modules and what they need, each after its needs. What is not there is built into the kernel."""
    order = []

    def add(name):
        key = name.replace("-", "_")
        if key in order or key not in by_name:
            return
        for need in needs(by_name[key]):
            add(need)
        order.append(key)

    for name in wanted:
        add(name)
    return order


def keep(work, name, kept):
    modules = work / f"root/lib/modules/{name}-rt-amd64/kernel"
    by_name = {path.stem.replace("-", "_"): path for path in [*modules.rglob("*.ko"), work / f"module/{GPIO_SIM}.ko"]}
    missing = [module for module in MODULES if module.replace("-", "_") not in by_name]
    if missing:
        raise KernelError(f"the kernel has no module {', '.join(missing)}")
    (kept / "modules").mkdir(parents=True)
    boot = load_order(by_name, BOOT_MODULES)
    rest = [module for module in load_order(by_name, [*BOOT_MODULES, *MODULES, GPIO_SIM]) if module not in boot]
    for module in [*boot, *rest]:
        shutil.copy(by_name[module], kept / f"modules/{module}.ko")
    (kept / "modules/boot").write_text("\n".join(boot) + "\n", encoding="utf-8")
    (kept / "modules/rest").write_text("\n".join(rest) + "\n", encoding="utf-8")
    shutil.copy(work / f"root/boot/vmlinuz-{name}-rt-amd64", kept / "vmlinuz")
    shutil.copy(work / "root/bin/busybox", kept / "busybox")
    (kept / f"whole-{RECIPE}").touch()


if __name__ == "__main__":
    try:
        print(ready_kernel(lambda text: print(text, flush=True)))
    except KernelError as error:
        print(error)
        sys.exit(2)
