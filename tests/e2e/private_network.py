# A network of this process's own, on which LCM's multicast reaches nobody else; needs Linux that lets users make one.
# SPDX-License-Identifier: BSD-3-Clause
import ctypes
import fcntl
import os
import shutil
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path

LCM_PORT = 7667


def enter():
    """Runs the calling script again in a namespace with multicast on its loopback; ends with 77 where that is not allowed."""
    if os.environ.get("KT_PRIVATE_NETWORK") == "1":
        set_up_loopback()
        return
    inside = ["unshare", "--user", "--map-root-user", "--net"]
    if shutil.which("unshare") is None or subprocess.run([*inside, "true"], capture_output=True, check=False).returncode != 0:
        print("skipped: this system lets no user make a network of their own (unshare -rn)")
        sys.exit(77)
    for program in ("lcm-logger", "lcm-logplayer"):
        if shutil.which(program) is None:
            print(f"skipped: {program} is not installed (Debian package liblcm-bin)")
            sys.exit(77)
    os.execvpe("unshare", [*inside, sys.executable, *sys.argv], {**os.environ, "KT_PRIVATE_NETWORK": "1"})


def set_up_loopback():
    """ip link set lo up multicast on; ip route add 224.0.0.0/4 dev lo"""
    get_flags, set_flags, add_route = 0x8913, 0x8914, 0x890B  # SIOCGIFFLAGS, SIOCSIFFLAGS, SIOCADDRT
    up, multicast, route_up = 0x1, 0x1000, 0x1
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        request = fcntl.ioctl(any_socket, get_flags, struct.pack("16sh22x", b"lo", 0))
        flags = struct.unpack("16sh22x", request)[1]
        fcntl.ioctl(any_socket, set_flags, struct.pack("16sh22x", b"lo", flags | up | multicast))

        def address(text):
            return struct.pack("HH4s8x", socket.AF_INET, 0, socket.inet_aton(text))

        device = ctypes.create_string_buffer(b"lo")
        # struct rtentry of a 64-bit Linux
        entry = struct.pack("L16s16s16sHhLLhhxxxxPLLH6x", 0, address("224.0.0.0"), address("0.0.0.0"), address("240.0.0.0"),
                            route_up, 0, 0, 0, 0, 0, ctypes.addressof(device), 0, 0, 0)
        fcntl.ioctl(any_socket, add_route, entry)


def wait_for_listeners(count, process):
    """Until so many sockets of this network listen to LCM's port; False where `process` ended before."""
    for _ in range(2400):
        lines = Path("/proc/net/udp").read_text().splitlines()[1:]
        if sum(int(line.split()[1].split(":")[1], 16) == LCM_PORT for line in lines) >= count:
            time.sleep(0.2)  # LCM tries its socket out before it hands messages on
            return True
        if process.poll() is not None:
            return False
        time.sleep(0.05)
    return False
