"""Every public name is documented, every example in a docstring runs, and the stub names what there is."""

import ast
import doctest
import inspect
from pathlib import Path

import pytest

import smooth_polylines as sp

CLASSES = [value for name in sp.__all__ if inspect.isclass(value := getattr(sp, name))]
STUB = ast.parse((Path(sp.__file__).parent / "_native.pyi").read_text(encoding="utf-8"))


def public_members(class_):
    return {name: member for name, member in vars(class_).items() if not name.startswith("_")}


def documented():
    yield "smooth_polylines", sp
    for class_ in CLASSES:
        yield class_.__name__, class_
        for name, member in public_members(class_).items():
            yield f"{class_.__name__}.{name}", member


@pytest.mark.parametrize(
    ("name", "what"), list(documented()), ids=lambda value: value if isinstance(value, str) else ""
)
def test_docstring_is_there_and_its_examples_run(name, what):
    text = inspect.getdoc(what)
    assert text, f"{name} has no docstring"
    assert text.splitlines()[0].rstrip().endswith((".", ":")) or "\n" in text
    examples = doctest.DocTestParser().get_doctest(text, {}, name, None, None)
    report = []
    result = doctest.DocTestRunner().run(examples, out=report.append)
    assert result.failed == 0, "".join(report)


def test_examples_exist_where_a_user_begins():
    for what in (
        sp.SurfaceMesh,
        sp.SurfaceMesh.network,
        sp.SurfaceMesh.line_from_bytes,
        sp.Polyline.on,
        sp.SurfacePoint,
    ):
        assert ">>>" in what.__doc__


def test_all_lists_every_public_name():
    assert sorted(sp.__all__) == sp.__all__ or set(sp.__all__) == set(dir(sp._native)) & set(sp.__all__)
    public = {name for name in dir(sp._native) if not name.startswith("_")} | {"__version__"}
    assert set(sp.__all__) == public


def test_the_stub_names_the_members_of_every_class():
    in_stub = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}
    for class_ in CLASSES:
        names = {item.name for item in in_stub[class_.__name__].body if isinstance(item, ast.FunctionDef)}
        assert {name for name in names if not name.startswith("_")} == set(public_members(class_)), class_.__name__


def test_the_stub_has_the_signatures_of_the_methods():
    classes = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}
    for class_ in CLASSES:
        for item in classes[class_.__name__].body:
            if not isinstance(item, ast.FunctionDef) or item.name.startswith("_") or item.decorator_list:
                continue
            arguments = [a.arg for a in (*item.args.posonlyargs, *item.args.args, *item.args.kwonlyargs)]
            assert arguments == list(inspect.signature(getattr(class_, item.name)).parameters)
            told = [ast.literal_eval(default) for default in (*item.args.defaults, *item.args.kw_defaults)]
            parameters = inspect.signature(getattr(class_, item.name)).parameters.values()
            assert told == [p.default for p in parameters if p.default is not p.empty]


def test_the_package_is_marked_as_typed():
    assert (Path(sp.__file__).parent / "py.typed").exists()


def test_the_version_is_a_version():
    assert all(part.isdigit() for part in sp.__version__.split("."))
