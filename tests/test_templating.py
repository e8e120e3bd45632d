"""A template may come from anybody: it shows values, ends, stays in its folder, and fails with its own line."""

from dataclasses import dataclass

import pytest
from cpu_time import cpu_time_below

from olp.core.diagnostic import OlpError
from olp.languages.templating import RenderingLimits, Sandbox, fixed, given, shipped, short


@dataclass(frozen=True)
class Row:
    seconds: float = 1.5
    name: str = "MOVL"

    def secret(self) -> str:
        return "called"


def render(folder, text, limits=None, **files):
    for name, content in files.items():
        (folder / f"{name}.j2").write_text(content, encoding="utf-8")
    path = folder / "main.j2"
    path.write_text(text, encoding="utf-8")
    return given(path).render({"row": Row(), "n": 7}, limits)


def refusal(folder, text, **files):
    with pytest.raises(OlpError) as caught:
        render(folder, text, **files)
    (found,) = caught.value.diagnostics
    return found


def test_a_template_sees_values_filters_loops_macros_and_includes(tmp_path):
    text = (
        "{% macro twice(x) %}{{ x }}{{ x }}{% endmacro %}"
        "{{ row.seconds|fixed(2) }} {{ row.name|lower ~ n }} {{ twice('ab') }} "
        "{% for c in 'xyz' %}{{ loop.index }}{{ c }}{% endfor %} {% include 'part.j2' %}"
    )
    assert render(tmp_path, text, part="[{{ n + 1 }}]") == "1.50 movl7 abab 1x2y3z [8]"


@pytest.mark.parametrize(
    "text",
    [
        "{{ row.__class__ }}",
        "{{ row.__doc__ }}",
        "{{ row.__module__ }}",
        "{{ ''.__class__.__mro__ }}",
        "{{ row['__class__'] }}",
        "{{ row.secret() }}",
        "{{ 'x'.upper() }}",
        "{{ '{0.__class__}'.format(row) }}",
        "{{ 'x' * 1000000000 }}",
        "{{ 2 ** 1000000000 }}",
        "{{ '%1000000000d' % 1 }}",
        "{{ row }}",
        "{{ [1, 2] }}",
    ],
)
def test_nothing_but_values_can_be_reached_or_written(tmp_path, text):
    assert refusal(tmp_path, text).code == "J003"


@pytest.mark.parametrize("name", ["range", "lipsum", "cycler", "joiner", "namespace", "dict"])
def test_the_global_functions_of_jinja_are_gone(tmp_path, name):
    assert refusal(tmp_path, f"{{{{ {name}(9) }}}}").code == "J002"


@pytest.mark.parametrize("name", ["attr", "center", "format", "indent", "map", "pprint", "replace", "tojson"])
def test_the_filters_of_jinja_that_can_multiply_text_or_reach_attributes_are_gone(tmp_path, name):
    assert refusal(tmp_path, f"{{{{ row.name|{name}(9) }}}}").code == "J001"


def nested(depth):
    return "{% for a in 'abcdefghijklmnop' %}" * depth + "x" + "{% endfor %}" * depth


def doubling_macros(depth):
    calls = "".join(
        f"{{% macro m{i}() %}}{{% set a = m{i - 1}() %}}{{% set b = m{i - 1}() %}}{{% endmacro %}}"
        for i in range(1, depth)
    )
    return f"{{% macro m0() %}}{{% endmacro %}}{calls}{{{{ m{depth - 1}() }}}}"


BOMBS = {
    "loops in loops": nested(12),
    "a macro that calls itself": "{% macro m() %}{{ m() }}{% endmacro %}{{ m() }}",
    "macros that call each other twice": doubling_macros(50),
    "a text doubled with ~": "{% set a = 'x' %}" + "{% set a = a ~ a %}" * 60 + "{{ a }}",
    "a text doubled by capturing": "{% set a = 'x' %}" + "{% set a %}{{ a }}{{ a }}{% endset %}" * 60,
    "a long text captured often": "{% macro m() %}"
    + "x" * 2000
    + "{% endmacro %}"
    + nested(4).replace("x", "{% set a = m() %}"),
    "a template that includes itself": "{% include 'main.j2' %}",
    "a template that includes itself twice": "{% set d = d + 1 if d is defined else 0 %}"
    "{% if d < 60 %}{% include 'main.j2' %}{% include 'main.j2' %}{% endif %}",
    "deep parentheses": "{{ " + "(" * 5000 + "1" + ")" * 5000 + " }}",
    "a huge number": "{{ " + " * ".join(["999999999"] * 9) + " }}",
}


@pytest.mark.parametrize("bomb", BOMBS)
def test_whatever_a_template_does_it_ends_soon(tmp_path, bomb):
    with cpu_time_below(5.0):
        assert refusal(tmp_path, BOMBS[bomb]).code == "J004"


def test_lists_of_lists_cannot_be_built(tmp_path):
    text = "{% set a = ['x'] %}" + "{% set a = [a, a] %}" * 60 + "{{ a == a }}"
    assert refusal(tmp_path, text).code == "J001"


def test_the_clock_stops_a_template_that_stays_within_all_counts(tmp_path):
    with pytest.raises(OlpError) as caught:
        render(tmp_path, nested(5), RenderingLimits(steps=10**9, characters=10**9, seconds=0.2))
    assert "0.2 s" in caught.value.diagnostics[0].message


def test_includes_stay_in_the_folder(tmp_path):
    (tmp_path / "secret.j2").write_text("SECRET")
    folder = tmp_path / "templates"
    folder.mkdir()
    (folder / "link.j2").symlink_to(tmp_path / "secret.j2")
    for name in ("../secret.j2", str(tmp_path / "secret.j2"), "link.j2", "..", "a/../../secret.j2"):
        assert refusal(folder, f"{{% include '{name}' %}}").code == "J005"


def test_a_user_template_can_include_one_of_olp(tmp_path):
    with pytest.raises(OlpError) as caught:
        render(tmp_path, "{% include 'inform.j2' %}")
    assert caught.value.diagnostics[0].message == "'jobs' is undefined"


@pytest.mark.parametrize(
    ("text", "line", "code"),
    [
        ("one\ntwo\n{{ missing }}\n", 3, "J002"),
        ("one\n{{ row.missing }}\n", 2, "J002"),
        ("one\n{% if %}\n", 2, "J001"),
        ("one\ntwo\n{{ 1 / 0 }}", 3, "J002"),
        ("{% macro m() %}\n{{ row.nothing }}\n{% endmacro %}\n{{ m() }}", 2, "J002"),
    ],
)
def test_a_mistake_is_told_with_its_line_in_the_template(tmp_path, text, line, code):
    found = refusal(tmp_path, text)
    assert (found.code, found.line, found.file) == (code, line, str(tmp_path / "main.j2"))
    assert found.source_line == text.splitlines()[line - 1]


def test_a_template_is_compiled_once_and_still_tells_its_mistakes(tmp_path, monkeypatch):
    first = refusal(tmp_path, "\n{{ missing }}")
    shipped("krl")
    monkeypatch.setattr(Sandbox, "compile", None)  # whoever calls it fails
    shipped("krl")
    assert refusal(tmp_path, "\n{{ missing }}") == first


def test_a_mistake_in_an_included_file_is_told_with_that_file(tmp_path):
    found = refusal(tmp_path, "\n\n{% include 'part.j2' %}", part="\n{{ missing }}")
    assert (found.line, found.file) == (2, str(tmp_path / "part.j2"))


def test_a_missing_template_and_one_that_is_no_text_are_diagnostics(tmp_path):
    with pytest.raises(OlpError) as caught:
        given(tmp_path / "none.j2")
    assert caught.value.diagnostics[0].code == "J005"
    (tmp_path / "bytes.j2").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(OlpError) as caught:
        given(tmp_path / "bytes.j2")
    assert caught.value.diagnostics[0].code == "J001"


def test_every_template_that_is_shipped_loads():
    from olp.core import resources

    names = resources.names("templates", ".j2")
    assert "inform" in names
    for name in names:
        shipped(name)


@pytest.mark.parametrize(
    ("value", "decimals", "text"),
    [(-0.0001, 2, "0.00"), (-0.0, 1, "0.0"), (0.0625, 3, "0.062"), (-7.25, 1, "-7.2"), (1e7, 0, "10000000")],
)
def test_fixed_never_writes_a_negative_zero(value, decimals, text):
    assert fixed(value, decimals) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [(592.4, "592"), (0.05331, "0.0533"), (123456, "123000"), (7.40, "7.4"), (0, "0"), (-9.996, "-10")],
)
def test_short_keeps_three_digits(value, text):
    assert short(value) == text
