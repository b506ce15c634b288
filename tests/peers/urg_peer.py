"""Our Hokuyo emulators, measured with by Hokuyo's own library (urg_library 1.2.0, from npm's package `urg`, compiled
here): over the serial line and over Ethernet, ranges with and without intensities, a part of the fan, clusters, and
skipped scans. Each range is held against a ray that this test casts.

Usage: urg_peer.py MARCO_SIM FOLDER_OF_NPM_PACKAGE    exit 0 = every value came true
"""
import ctypes
import glob
import math
import os
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, "..", "process"))
import foreign_lasers as room  # noqa: E402

SERIAL, ETHERNET = 0, 1
DISTANCE, WITH_INTENSITY = 0, 1
SCANS = 40
LINE_BYTES = 60_000  # a line holds 64 KiB for a reader that comes late; what is sent beyond is lost
PART = (-100, 151)  # steps from ahead, 84 groups of three


def compiled(package, folder):
    sources = [path for path in glob.glob(package + "/src/*.c") if "windows" not in path and not path.endswith("_linux.c")]
    library = folder + "/liburg.so"
    subprocess.run(["cc", "-w", "-O1", "-shared", "-fPIC", "-I", package + "/include/c", "-o", library, *sources, "-lm"], check=True)
    urg = ctypes.CDLL(library)
    urg.urg_index2rad.restype = ctypes.c_double
    urg.urg_index2rad.argtypes = [ctypes.c_void_p, ctypes.c_int]
    urg.urg_step2rad.restype = ctypes.c_double
    for name in ("urg_error", "urg_sensor_product_type", "urg_sensor_serial_id", "urg_sensor_status"):
        getattr(urg, name).restype = ctypes.c_char_p
        getattr(urg, name).argtypes = [ctypes.c_void_p]
    urg.urg_scan_usec.restype = ctypes.c_long
    return urg


class Sensor:
    def __init__(self, urg, kind, device, number):
        self.urg, self.state = urg, ctypes.create_string_buffer(1 << 16)  # larger than its urg_t
        begun = time.monotonic()
        while self.urg.urg_open(self.state, kind, device.encode(), ctypes.c_long(number)) < 0:
            if time.monotonic() - begun > room.PATIENCE_S:
                sys.exit(f"FAILED: urg_open: {self.told()}")
            time.sleep(0.1)
        # By default it waits for sixteen turns (0.4 s of a UST-10LX), and takes a line that stops for longer for a whole one.
        self.urg.urg_set_timeout_msec(self.state, int(1000 * room.PATIENCE_S))

    def told(self):
        return self.urg.urg_error(self.state).decode(errors="replace")

    def call(self, name, *arguments):
        result = getattr(self.urg, name)(self.state, *arguments)
        if result < 0:
            sys.exit(f"FAILED: {name}: {self.told()}")
        return result

    def scans(self, what, kind, tolerance_m, grouped=1, skip=0):
        """Measures, and then holds every range against the room's wall: the laser does not wait while this test computes."""
        size = self.urg.urg_max_data_size(self.state)
        wanted = min(SCANS, LINE_BYTES // (size * (3 if kind == DISTANCE else 6) * 66 // 64 + 100))
        taken = [((ctypes.c_long * size)(), (ctypes.c_ushort * size)(), ctypes.c_long()) for _ in range(wanted)]
        self.call("urg_start_measurement", kind, wanted, skip)
        for ranges, intensities, stamp in taken:
            count = (self.call("urg_get_distance", ranges, ctypes.byref(stamp)) if kind == DISTANCE else
                     self.call("urg_get_distance_intensity", ranges, intensities, ctypes.byref(stamp)))
        self.call("urg_stop_measurement")
        for ranges, _, _ in taken:
            for i in range(count):
                if grouped == 1:
                    bearing = -math.degrees(self.urg.urg_index2rad(self.state, i))
                    room.check_range(what, bearing, ranges[i] / 1000, 0.001, tolerance_m)
                else:  # the library knows the bearing of a step, not that of a group
                    group = [room.true_range_m(-math.degrees(self.urg.urg_step2rad(self.state, PART[0] + grouped * i + step)))
                             for step in range(grouped)]
                    room.check(f"{what} {i}", ranges[i] / 1000, min(group), tolerance_m)
        return count, [stamp.value for _, _, stamp in taken]


def judged(urg, kind, device, number, product, tolerance_m, intensities):
    sensor = Sensor(urg, kind, device, number)
    name = urg.urg_sensor_product_type(sensor.state).decode()
    room.check("product", product in name, True)
    room.check("serial number", len(urg.urg_sensor_serial_id(sensor.state)) > 0, True)
    # It knows what later lasers say; a URG-04LX says "Sensor works well."
    room.check("stable", sensor.call("urg_is_stable"), 0 if product == "URG-04LX" else 1)
    turn_ms = urg.urg_scan_usec(sensor.state) / 1000
    low, high = ctypes.c_int(), ctypes.c_int()
    urg.urg_step_min_max(sensor.state, ctypes.byref(low), ctypes.byref(high))
    count, stamps = sensor.scans("range", DISTANCE, tolerance_m)
    room.check("beams", count, high.value - low.value + 1)
    room.check("milliseconds of all turns", stamps[-1] - stamps[0], (len(stamps) - 1) * turn_ms, turn_ms)
    _, stamps = sensor.scans("range of every third turn", DISTANCE, tolerance_m, skip=2)
    room.check("milliseconds of every third turn", stamps[-1] - stamps[0], 3 * (len(stamps) - 1) * turn_ms, 3 * turn_ms)
    sensor.call("urg_set_scanning_parameter", *PART, 1)
    count, _ = sensor.scans("range of a part", DISTANCE, tolerance_m)
    room.check("beams of a part", count, 252)
    sensor.call("urg_set_scanning_parameter", *PART, 3)
    count, _ = sensor.scans("least range of three", DISTANCE, tolerance_m, grouped=3)
    room.check("groups", count, 84)
    sensor.call("urg_set_scanning_parameter", low.value, high.value, 1)
    if intensities:
        sensor.scans("range beside an intensity", WITH_INTENSITY, tolerance_m)
    sensor.call("urg_reboot")
    urg.urg_close(sensor.state)


MODELS = {
    "hokuyo": ("URG-04LX", 0.002, False),
    "hokuyo_utm": ("UTM-30LX", 0.002, True),
    "hokuyo_ust": ("UST-10LX", 0.002, True),
}


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as folder:
        urg = compiled(sys.argv[2], folder)
        for device, (product, tolerance_m, intensities) in MODELS.items():
            with room.simulated(sys.argv[1], device) as port:
                begun, before = time.monotonic(), room.checks
                address = (ETHERNET, "127.0.0.1", port) if isinstance(port, int) else (SERIAL, port, 115200)
                judged(urg, *address, product, tolerance_m, intensities)
                print(f"{device}: {room.checks - before} checks in {time.monotonic() - begun:.1f} s", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
