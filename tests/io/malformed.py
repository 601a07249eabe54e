"""Ways in which files come damaged: of their bytes, of their text, of their TOML. Every way is drawn from one seed."""

import codecs

WORDS = (
    *(
        "",
        " ",
        "nan",
        "NaN",
        "inf",
        "-Infinity",
        "1e309",
        "-1e309",
        "1e-400",
        "1e30",
        "-9999",
        "n/a",
        "NA",
        "--",
        "1,5",
    ),
    *(
        "1.2.3",
        "1e",
        "0x1F",
        "1_000",
        "１２",
        "٣",
        "½",
        "NaN(7)",
        "#",
        '"',
        '""',
        '"1',
        "'1'",
        "1;2",
        "\ufeff1",
        "\u2028",
    ),
    *("1" * 400, "9" * 5000, "-", "+", "true", "None", "\t", "\\", "=1+1", "1 2", "\x0b", "\x1b[31m", "a" * 300, "0"),
)
NASTY_BYTES = (
    b"\x00",
    b"\xff",
    b"\xb5",
    b"\xef\xbb\xbf",
    b"\xff\xfe",
    b"\r",
    b"\n\n",
    b"\x1a",
    b"\xed\xa0\x80",
    b"\xf8",
)
TOML_WORDS = (
    *(
        "0",
        "-1",
        "1.5",
        "true",
        "nan",
        "-inf",
        '""',
        "[]",
        "{}",
        "[[]]",
        "[{}]",
        '"???"',
        "'''x'''",
        "1979-05-27",
        "07:32",
    ),
    *('"1 s"', '"1 mm"', '"-5 ms"', '"0 ms"', '"1e400 s"', '"nan s"', '"1 foo"', '"1"', '"rows"', '"mat"', '"parquet"'),
    *("9" * 5000, "0x" + "f" * 400, "1e999", '"' + "x" * 5000 + '"', "[" * 300, "{ row = 0 }", "{ column = 'yaw' }"),
    *(
        "{ variable = 'a.b(1)' }",
        '{ file_name = "(" }',
        '"\\u0000"',
        "{ unit = 'ms' }",
        '"(a+)+$"',
        "0xg",
        "-0",
        "1__0",
    ),
)


def damaged_bytes(data, rng):
    """Cut, flip, overwrite, move, repeat or drop a few bytes, once or several times."""
    damaged = bytearray(data)
    for _ in range(rng.choice((1, 1, 1, 2, 5))):
        if not damaged:
            break
        rng.choice((_cut, _flip, _overwrite, _move, _repeat, _drop, _insert, _number))(damaged, rng)
    return bytes(damaged)


def damaged_table(data, rng, delimiter):
    """Damage fields, lines, separators or the encoding of a text table, or its bytes."""
    if rng.random() < 0.15:
        return damaged_bytes(data, rng)
    text = data.decode("utf-8")
    for _ in range(rng.choice((1, 1, 2, 4))):
        text = rng.choice((_field, _field, _line, _separators, _width, _column))(text, rng, delimiter)
    return _encoded(text, rng)


def damaged_toml(data, rng):
    """Damage a value, a key, a line or the bytes of a TOML file."""
    if rng.random() < 0.1:
        return damaged_bytes(data, rng)
    lines = data.decode("utf-8").splitlines()
    for _ in range(rng.choice((1, 1, 2, 3))):
        k = rng.randrange(len(lines))
        key, equals, value = lines[k].partition("=")
        how = rng.randrange(7)
        if how <= 2 and equals:
            lines[k] = f"{key}= {rng.choice(TOML_WORDS)}"
        elif how == 3 and equals:
            lines[k] = f"{_damaged_word(key, rng)} = {value}"
        elif how == 4:
            lines.insert(k, lines[rng.randrange(len(lines))])
        elif how == 5 and len(lines) > 1:
            del lines[k]
        else:
            lines[k] = _damaged_word(lines[k], rng)
    return _encoded("\n".join(lines), rng)


def _damaged_word(word, rng):
    k = rng.randrange(len(word) + 1)
    return word[:k] + rng.choice((*WORDS, "[", "]", "{", "}", "=", ".", ",", "'")) + word[k + rng.randrange(3) :]


def _encoded(text, rng):
    how = rng.randrange(30)
    if how == 0:
        return codecs.BOM_UTF8 + text.encode("utf-8", "replace")
    if how == 1:
        return text.encode("utf-16", "replace")
    if how == 2:
        return text.encode("latin-1", "replace")
    if how == 3:
        return text.replace("\n", rng.choice(("\r\n", "\r", "\n\n", "\x0b", "\u2028"))).encode("utf-8", "replace")
    data = text.encode("utf-8", "replace")
    if how == 4:
        k = rng.randrange(len(data) + 1)
        return data[:k] + rng.choice(NASTY_BYTES) + data[k:]
    return data


def _field(text, rng, delimiter):
    lines = text.split("\n")
    k = rng.randrange(len(lines))
    fields = lines[k].split(delimiter)
    fields[rng.randrange(len(fields))] = rng.choice(WORDS)
    lines[k] = delimiter.join(fields)
    return "\n".join(lines)


def _line(text, rng, _delimiter):
    lines = text.split("\n")
    k, other = rng.randrange(len(lines)), rng.randrange(len(lines))
    how = rng.randrange(5)
    if how == 0:
        del lines[k]
    elif how == 1:
        lines.insert(k, lines[other])
    elif how == 2:
        lines[k], lines[other] = lines[other], lines[k]
    elif how == 3:
        lines = lines[: k + 1]
    else:
        lines[k] = rng.choice(("", "# comment", '"', lines[k] * 50, "," * 3000, "\t" * 50, "a b c"))
    return "\n".join(lines)


def _separators(text, rng, delimiter):
    other = rng.choice((";", "\t", " ", ",", "|", "  ", ", ", "\u00a0"))
    if rng.random() < 0.3:
        return text.replace(".", ",")  # decimal commas
    if rng.random() < 0.5:
        return text.replace(delimiter, other)
    lines = text.split("\n")
    k = rng.randrange(len(lines))
    lines[k] = lines[k].replace(delimiter, other)
    return "\n".join(lines)


def _width(text, rng, delimiter):
    lines = text.split("\n")
    k = rng.randrange(len(lines))
    lines[k] = rng.choice((lines[k] + delimiter, delimiter + lines[k], lines[k].rpartition(delimiter)[0]))
    return "\n".join(lines)


def _column(text, rng, delimiter):
    """Replace a whole column: by one word, by its reverse, scaled, or by another column."""
    rows = [line.split(delimiter) for line in text.split("\n")]
    k = rng.randrange(max(map(len, rows)))
    values = [row[k] if k < len(row) else "" for row in rows]
    word, how = rng.choice(WORDS), rng.randrange(4)
    for row, value, mirrored in zip(rows, values, values[::-1], strict=True):
        if k < len(row):
            row[k] = (word, mirrored, f"{value}e3", row[0])[how]
    return "\n".join(delimiter.join(row) for row in rows)


def _cut(damaged, rng):
    del damaged[rng.randrange(len(damaged)) :]


def _flip(damaged, rng):
    damaged[rng.randrange(len(damaged))] ^= 1 << rng.randrange(8)


def _overwrite(damaged, rng):
    k = rng.randrange(len(damaged))
    count = min(rng.choice((1, 2, 4, 8, 64)), len(damaged) - k)
    damaged[k : k + count] = bytes([rng.choice((0, 1, 127, 128, 255))]) * count


def _move(damaged, rng):
    k, other, count = rng.randrange(len(damaged)), rng.randrange(len(damaged)), rng.randrange(1, 65)
    damaged[k : k + count] = damaged[other : other + count]


def _repeat(damaged, rng):
    k, count = rng.randrange(len(damaged)), rng.randrange(1, 257)
    damaged[k:k] = damaged[k : k + count]


def _drop(damaged, rng):
    k, count = rng.randrange(len(damaged)), rng.choice((1, 2, 3, 4, 8, 100))
    del damaged[k : k + count]


def _insert(damaged, rng):
    k = rng.randrange(len(damaged) + 1)
    damaged[k:k] = rng.randbytes(rng.choice((1, 2, 4, 8, 100)))


def _number(damaged, rng):
    """Overwrite four or eight aligned bytes by a number that lengths and offsets do not expect."""
    size = rng.choice((2, 4, 8))
    k = rng.randrange(len(damaged)) // size * size
    number = rng.choice((0, 1, 2**31 - 1, 2**31, 2**32 - 1, 10**9, rng.randrange(2**16), len(damaged), 7))
    order = rng.choice(("little", "big"))
    damaged[k : k + size] = (number % (1 << 8 * size)).to_bytes(size, order)
