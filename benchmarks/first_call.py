"""CPU times of the first response in a new process: imports, then the call, its kernels compiled or from the cache."""

import json
import sys
import time

began = time.process_time()
import loops  # noqa: E402 (its import is what is timed)

imported = time.process_time()
loops.recover(json.load(sys.stdin))
json.dump({"import_s": imported - began, "first_call_s": time.process_time() - imported}, sys.stdout)
