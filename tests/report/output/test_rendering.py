"""What a page holds packed."""

import base64
import re
import zlib

from hypothesis import given
from hypothesis import strategies as st

from gsiirl.report.output.rendering import packed


@given(st.text())
def test_what_is_packed_comes_out_again_and_cannot_end_the_script_that_holds_it(text: str) -> None:
    for each in (text, f"{text}</script><!--"):
        assert re.fullmatch(r"[A-Za-z0-9+/]+=*", packed(each))
        assert zlib.decompress(base64.b64decode(packed(each))).decode() == each
