"""What a map's wave gauges read of `pier`, beside the sea at the same places: turns at a pier's end, a wire's height.

python -m validation.retrieval.gauges
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import seamap_rt as sr

from ..options import options


def main() -> None:
    options(__doc__)
    with TemporaryDirectory() as folder:
        metrics = sr.run("pier", folder, draw=lambda *_: Path(folder)).metrics
    print("| gauge | turns | correlation | rms, m | bias, m | stated, m | Hs of the wire, m | Hs of the maps, m |")
    print("|---|---|---|---|---|---|---|---|")
    for each in metrics["gauges"]:
        print(
            f"| {each['name']} | {each['turns']} | {each['correlation']:.3f} | {each['rms_error_m']:.3f} "
            f"| {each['bias_m']:.3f} | {each['stated_error_m']:.3f} | {each['hs_wire_m']:.2f} "
            f"| {each['hs_retrieved_m']:.2f} |"
        )


if __name__ == "__main__":
    main()
