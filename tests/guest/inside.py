# SPDX-License-Identifier: Apache-2.0
"""Runs the cases inside the guest, in turn, and writes a line of results for each into the shared folder."""
import importlib
import json
import signal
import sys
import time
import traceback
from pathlib import Path

HERE = Path(__file__).resolve().parent
SHARE = Path("/mnt")
sys.path.insert(0, str(HERE))

from support.guest import Guest  # noqa: E402  (found only with the path above)


def on_alarm(_number, _frame):
    raise TimeoutError("the case took longer than its limit")


def run(name, request):
    """(ok, what was wrong)."""
    guest = Guest(Path(request["build"]), Path(request["root"]), SHARE / name)
    try:
        case = importlib.import_module(f"cases.{name}")
        signal.alarm(getattr(case, "LIMIT_S", 120))
        case.run(guest)
        return True, ""
    except AssertionError as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        return False, f"{error} ({Path(place.filename).name}:{place.lineno})"
    except Exception as error:  # whatever a case throws is its result, and the next one runs
        place = traceback.extract_tb(error.__traceback__)[-1]
        return False, f"{type(error).__name__}: {error} ({Path(place.filename).name}:{place.lineno})"
    finally:
        signal.alarm(0)
        guest.close()


def main():
    request = json.loads((SHARE / "request.json").read_text(encoding="utf-8"))
    signal.signal(signal.SIGALRM, on_alarm)
    for name in request["cases"]:
        begin = time.monotonic()
        ok, text = run(name, request)
        seconds = round(time.monotonic() - begin, 1)
        print(f"{'ok' if ok else 'failed':6} {name}: {seconds} s{'' if ok else ', ' + text}", flush=True)
        with open(SHARE / "results.jsonl", "a", encoding="utf-8") as out:
            out.write(json.dumps({"name": name, "ok": ok, "seconds": seconds, "text": text}) + "\n")


main()
