"""Numbers that stand in the prose of README and docs, for tests that compute them."""

import re
from pathlib import Path

ROOT = Path(__file__).parent.parent
RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-")
POWER = r"10[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+"
NUMBER = rf"{POWER}|[+−-]?\d[\d,]*(?:\.\d+)?(?:·{POWER}|e-?\d+)?(?: ?%)?"


def read_number(written):
    """(value, one unit of the last digit) of a number as pages have it; percents as fractions."""
    plain = re.sub(rf"^(?={POWER})", "1·", written)
    plain = plain.replace("·10", "e").translate(RAISED).replace(",", "")
    scale = 0.01 if plain.endswith("%") else 1.0
    mantissa, _, exponent = plain.rstrip(" %").partition("e")
    scale *= 10.0 ** int(exponent or 0)
    _, _, decimals = mantissa.partition(".")
    return float(mantissa) * scale, 10.0 ** -len(decimals) * scale


def quoted_numbers(page, sentence):
    """What stands for every {} of a sentence of a page, as `read_number`; white space is free."""
    parts = [r"\s+".join(map(re.escape, part.split(" "))) for part in sentence.split("{}")]
    pattern = f"({NUMBER})".join(parts)
    found = re.findall(pattern, (ROOT / page).read_text(encoding="utf-8"))
    assert found, f"{page} does not say {sentence!r}"
    assert len(set(found)) == 1, f"{page} says {sentence!r} in several ways: {found}"
    numbers = [found[0]] if isinstance(found[0], str) else found[0]
    return [read_number(number) for number in numbers]


def assert_page_says(page, sentence, *values, units=0.6):
    """Fail unless the numbers of a sentence are these, to some units of their last digits."""
    numbers = quoted_numbers(page, sentence)
    for (number, unit), value in zip(numbers, values, strict=True):
        assert abs(value - number) <= units * unit, f"{page}: {sentence!r}: {number} is {value:.6g}"
