# The files of a mission, for tools in Python: recordings read and written as folders, poses read from a log.
# SPDX-License-Identifier: BSD-3-Clause
import math
import re
import struct
import zlib
from bisect import bisect_left
from dataclasses import dataclass, field
from pathlib import Path

PAIRING_S = 0.02  # as kintsugi-collect pairs colour with depth, and kintsugi-eval poses


@dataclass(frozen=True)
class Rigid:
    """A rigid transform: p -> rotation p + translation; the rotation row by row."""
    rotation: tuple
    translation: tuple

    def __matmul__(self, other):
        a, b = self.rotation, other.rotation
        product = tuple(tuple(sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)) for i in range(3))
        return Rigid(product, self.apply(other.translation))

    def apply(self, point):
        return tuple(sum(row[k] * point[k] for k in range(3)) + t for row, t in zip(self.rotation, self.translation))

    def inverse(self):
        transposed = tuple(zip(*self.rotation))
        return Rigid(transposed, tuple(-sum(row[k] * self.translation[k] for k in range(3)) for row in transposed))

    def angle(self):
        """Of its rotation, in radians."""
        trace = sum(self.rotation[i][i] for i in range(3))
        sine = math.sqrt(sum((self.rotation[i][j] - self.rotation[j][i]) ** 2 for i, j in ((0, 1), (1, 2), (2, 0)))) / 2
        return math.atan2(sine, (trace - 1) / 2)


def rotation_of(x, y, z, w):
    """The matrix of a quaternion, which need not be of length 1."""
    s = 2 / (x * x + y * y + z * z + w * w)
    return ((1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w)),
            (s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w)),
            (s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y)))


def quaternion_of(r):
    """(x, y, z, w) of a rotation matrix, from its largest component."""
    trace = r[0][0] + r[1][1] + r[2][2]
    squares = [1 + 2 * r[i][i] - trace for i in range(3)] + [1 + trace]
    largest = max(range(4), key=squares.__getitem__)
    scale = 2 * math.sqrt(squares[largest])
    differences = (r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1])
    if largest == 3:
        return (*(d / scale for d in differences), scale / 4)
    q = [(r[i][largest] + r[largest][i]) / scale for i in range(3)] + [differences[largest] / scale]
    q[largest] = scale / 4
    return tuple(q)


@dataclass(frozen=True)
class Frame:
    """A frame of a recording or of what is made from one."""
    stamp_us: int
    depth: Path
    colour: Path | None
    truth: Rigid | None = None  # camera to world
    world: str = ""             # poses of two worlds cannot be compared
    is_damaged: bool = False    # its images were altered
    is_jump: bool = False       # the camera did not move here: it was carried off


@dataclass
class Recording:
    name: str
    frames: list = field(default_factory=list)
    calibration: str | None = None  # the text of calibration.yaml
    camera: str | None = None       # where there is none: what kintsugi-collect takes as --calibration
    depth_unit_m: float = 0.0002

    def interval_us(self):
        """The median time between frames."""
        steps = sorted(b.stamp_us - a.stamp_us for a, b in zip(self.frames, self.frames[1:]))
        return steps[len(steps) // 2] if steps else 33333


def rows(path):
    """The fields of every line that is no comment."""
    for line in path.read_text().splitlines():
        if line.strip() and not line.startswith("#"):
            yield line.split()


def microseconds(seconds):
    return round(float(seconds) * 1e6)


def nearest(stamps, stamp_us):
    """The index of the stamp nearest to `stamp_us`, or nothing where it is too far to belong to it."""
    at = bisect_left(stamps, stamp_us)
    best = min((i for i in (at - 1, at) if 0 <= i < len(stamps)), key=lambda i: abs(stamps[i] - stamp_us), default=None)
    return best if best is not None and abs(stamps[best] - stamp_us) <= PAIRING_S * 1e6 else None


def read_tum(folder):
    recording = Recording(folder.name)
    # The camera of a TUM recording is known by the folder's name.
    camera = re.search(r"(?:^|[^a-z0-9])(?:freiburg|fr)([123])(?:$|[^a-z0-9])", folder.name.lower())
    recording.camera = f"tum-fr{camera[1]}" if camera else None
    lists = {name: sorted((microseconds(row[0]), row[1:]) for row in rows(folder / name)) if (folder / name).exists() else []
             for name in ("depth.txt", "rgb.txt", "groundtruth.txt")}
    stamps = {name: [stamp for stamp, _ in entries] for name, entries in lists.items()}

    def paired(name, stamp_us):
        found = nearest(stamps[name], stamp_us)
        return None if found is None else lists[name][found][1]

    for stamp_us, (depth, *_) in lists["depth.txt"]:
        colour, truth = paired("rgb.txt", stamp_us), paired("groundtruth.txt", stamp_us)
        if truth:
            values = [float(value) for value in truth]
            truth = Rigid(rotation_of(*values[3:7]), tuple(values[:3]))
        recording.frames.append(Frame(stamp_us, folder / depth, folder / colour[0] if colour else None, truth, folder.name))
    return recording


def read_seven_scenes(folder):
    recording = Recording(folder.name, camera="7scenes", depth_unit_m=0.001)
    for depth in sorted(folder.glob("frame-*.depth.png")):
        stem = depth.name.removesuffix(".depth.png")
        colour = next((folder / f"{stem}.color{ending}" for ending in (".png", ".jpg")
                       if (folder / f"{stem}.color{ending}").exists()), None)
        pose, truth = folder / f"{stem}.pose.txt", None
        if pose.exists():
            matrix = [[float(value) for value in row] for row in rows(pose)]
            truth = Rigid(tuple(tuple(row[:3]) for row in matrix[:3]), tuple(row[3] for row in matrix[:3]))
        stamp_us = microseconds(1 + int(stem.removeprefix("frame-")) / 30)
        recording.frames.append(Frame(stamp_us, depth, colour, truth, folder.name))
    return recording


def read_recording(folder):
    """A TUM RGB-D or 7-Scenes folder; ValueError where it is none."""
    folder = folder.resolve()
    if (folder / "depth.txt").exists():
        recording = read_tum(folder)
    elif any(folder.glob("frame-*.depth.png")):
        recording = read_seven_scenes(folder)
    else:
        raise ValueError(f"{folder} is no TUM RGB-D or 7-Scenes recording")
    if (folder / "calibration.yaml").exists():
        recording.calibration = (folder / "calibration.yaml").read_text()
        unit = re.search(r"^depth_unit_m:\s*(\S+)", recording.calibration, re.MULTILINE)
        recording.depth_unit_m = float(unit[1]) if unit else recording.depth_unit_m
    return recording


def write_tum(folder, frames, calibration=None):
    """A folder in TUM layout whose lists lead to the images of `frames`, wherever they lie."""
    folder.mkdir(parents=True, exist_ok=True)
    links = {}  # a link per folder of images: a list cannot hold a path with a space

    def listed(path):
        if path.parent not in links:
            link = links[path.parent] = folder / f"images-{len(links)}"
            link.unlink(missing_ok=True)
            link.symlink_to(path.parent.resolve(), target_is_directory=True)
        return f"{links[path.parent].name}/{path.name}"

    def stamp(frame):
        return f"{frame.stamp_us // 1000000}.{frame.stamp_us % 1000000:06d}"

    (folder / "depth.txt").write_text("".join(f"{stamp(f)} {listed(f.depth)}\n" for f in frames))
    (folder / "rgb.txt").write_text("".join(f"{stamp(f)} {listed(f.colour)}\n" for f in frames if f.colour))
    if calibration:
        (folder / "calibration.yaml").write_text(calibration)


def image_size(path):
    """(width, height) of a PNG or JPEG."""
    content = path.read_bytes()
    if content.startswith(b"\x89PNG"):
        return struct.unpack_from(">II", content, 16)
    position = 2
    while content[position] == 0xFF:
        marker, length = content[position + 1], struct.unpack_from(">H", content, position + 2)[0]
        if 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):  # a frame header
            height, width = struct.unpack_from(">HH", content, position + 5)
            return width, height
        position += 2 + length
    raise ValueError(f"{path} is neither a PNG nor a JPEG")


def write_png(path, width, height, pixels, bits, channels):
    """`pixels`: the samples row by row, those of 16 bits in big-endian order."""
    row = width * channels * bits // 8
    if len(pixels) != row * height:
        raise ValueError(f"{len(pixels)} bytes for {width} x {height} pixels of {channels} x {bits} bits")

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    unfiltered = b"".join(b"\0" + pixels[i * row:(i + 1) * row] for i in range(height))
    header = struct.pack(">IIBBBBB", width, height, bits, {1: 0, 3: 2}[channels], 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(unfiltered, 1)) +
                     chunk(b"IEND", b""))


@dataclass(frozen=True)
class LoggedPose:
    """A pose of a log; see lcmtypes/pose_t.lcm."""
    stamp_us: int
    T_odom_camera: Rigid
    segment: int
    is_good: bool
    source: int
    cause: int


SOURCES = ("none", "start", "model", "features", "pairwise", "relocalised", "prior")
POSE_BYTES = 348  # of an encoded pose_t


def read_poses(log):
    """The poses of an intact LCM log, in its order."""
    content, position, poses = Path(log).read_bytes(), 0, []
    while position < len(content):
        sync, _, _, channel_size, size = struct.unpack_from(">IqqII", content, position)
        if sync != 0xEDA1DA01:
            raise ValueError(f"{log} is damaged at byte {position}")
        begin = position + 28 + channel_size
        channel, position = content[position + 28:begin], begin + size
        if channel != b"KINTSUGI_POSE":
            continue
        if size != POSE_BYTES:
            raise ValueError(f"{log} holds poses of {size} bytes instead of {POSE_BYTES}: of another version")
        # fingerprint, message sequence, stamp, checksum, frame, pose, edge and quality, segment, four small ones
        fields = struct.unpack_from(">8x8xq4x8x12d8x21d4dibbbb", content, begin)
        matrix = fields[1:13]
        segment, _, status, source, cause = fields[-5:]
        rotation = tuple(tuple(matrix[4 * i:4 * i + 3]) for i in range(3))
        poses.append(LoggedPose(fields[0], Rigid(rotation, tuple(matrix[3::4])), segment, status == 0, source, cause))
    return poses
