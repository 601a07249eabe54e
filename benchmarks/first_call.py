"""The first response in a new process: imports, and the first call with its kernels compiled or read from the cache."""

import json
import sys
import time

began = time.perf_counter()
import loops  # noqa: E402 (its import is what is timed)

imported = time.perf_counter()
loops.recover(json.load(sys.stdin))
json.dump({"import_s": imported - began, "first_call_s": time.perf_counter() - imported}, sys.stdout)
