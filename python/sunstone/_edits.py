"""Edits of scenes by name: `KIND/NAME/KEY`, or attributes of what a name means."""

from __future__ import annotations

import numbers
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from . import _sunstone
from ._errors import SceneError


class Parts(Mapping[str, Any]):
    """What a scene that was made in code is made of: the calls of `World`, before edits and now.

    As a mapping, the edits: what is other now than it was.
    """

    #: What edits call the things that calls make.
    KINDS = {
        "add_material": "materials",
        "add_medium": "media",
        "add_mesh": "nodes",
        "add_sphere": "nodes",
        "add_light": "lights",
        "set_camera": "cameras",
    }
    #: What a call takes between the name and its keys.
    LEADING = {"add_mesh": "geometry", "add_sphere": "radius"}

    def __init__(self, name: str, base: list[Any], steps: list[Any] | None = None) -> None:
        self.name = name
        self.base = base
        self.steps = base if steps is None else steps

    def add(self, step: Any) -> None:
        """Goes on with a call, which no edit has changed yet."""
        self.steps.append(step)
        if self.base is not self.steps:
            self.base.append(step)

    def edited(self, edits: Mapping[str, Any]) -> Parts:
        """With other values; None is that of a key that is not given."""
        steps = list(self.steps)
        taken: list[tuple[str, int, list[str]]] = []
        for target, value in edits.items():
            index, path = self._find(target)
            for other, of, there in taken:
                if of == index and all(a == b for a, b in zip(path, there)):
                    problem = f"is of the same place as {other}\n  help: set it once"
                    raise SceneError(f"{target} {problem}")
            taken.append((target, index, path))
            keys = _keys_of(steps[index])
            if len(path) > 1 and path[0] not in keys:
                raise SceneError(f"{target}: there is no `{path[0]}` in it\n  help: set the whole")
            keys[path[0]] = _with(keys.get(path[0]), path[1:], value, target)
            steps[index] = _step_of(steps[index], keys)
        return Parts(self.name, self.base, steps)

    def taken_back(self, targets: Iterable[str]) -> Parts | None:
        """With the values that there were before edits, of places or of all of KIND/NAME."""
        steps = list(self.steps)
        for target in targets:
            if target.count("/") == 1:
                index, _ = self._find(f"{target}/all")
                steps[index] = self.base[index]
                continue
            index, (key, *_) = self._find(target)
            before = _keys_of(self.base[index]).get(key)
            steps[index] = _step_of(steps[index], {**_keys_of(steps[index]), key: before})
        taken = Parts(self.name, self.base, steps)
        return taken if list(taken.items()) != list(self.items()) else None

    @property
    def has_film_size(self) -> bool:
        """Whether the size of the film is edited."""
        sizes = [_keys_of(steps[index]).get("resolution")
                 for index in self._all("cameras") for steps in (self.steps, self.base)]
        return len(sizes) == 2 and not _same(*sizes)

    def default_of(self, target: str) -> str | None:
        """What holds where no value is given; the methods of `World` tell."""
        return None

    def value(self, target: str) -> tuple[bool, Any]:
        """Whether a value is given, and which."""
        index, path = self._find(target)
        value: Any = _keys_of(self.steps[index])
        for key in path:
            found = value.get(key) if isinstance(value, Mapping) else _item(value, key)
            if found is None:
                return False, None
            value = found
        return True, _fixed(value)

    def objects(self, name: str) -> list[str]:
        """The objects that a name may mean, as KIND/NAME."""
        kinds = list(dict.fromkeys(self.KINDS.values()))
        kind, _, inner = name.partition("/")
        if kind in kinds and self._indices(kind, inner):
            return [name]
        found = [f"{kind}/{name}" for kind in kinds if self._indices(kind, name)]
        if not found:
            names = [f"{kind}/{self.steps[index][1][0]}"
                     for kind in kinds for index in self._all(kind)]
            known = f", or one of {_some(names)}" if names else "; there is nothing yet"
            remedy = f"write KIND/NAME/KEY{known}"
            raise SceneError(f"{name}: nothing is called so\n  help: {remedy}")
        return found

    def keys_of(self, path: str) -> list[str]:
        """The keys that an object was given, and what others of its kind were."""
        kind, _, name = path.partition("/")
        given = [list(_keys_of(self.steps[index])) for index in self._all(kind)]
        return sorted({key for keys in given for key in keys})

    def __getitem__(self, target: str) -> Any:
        return dict(self.items())[target]

    def __iter__(self) -> Any:
        for kind in dict.fromkeys(self.KINDS.values()):
            for number, index in enumerate(self._all(kind)):
                if self.steps[index] is self.base[index]:
                    continue
                name = self.steps[index][1][0]
                is_one = len(self._indices(kind, name)) == 1
                called = name if is_one else self._number(kind, number)
                now, before = _keys_of(self.steps[index]), _keys_of(self.base[index])
                for key in {**before, **now}:
                    if not _same(now.get(key), before.get(key)):
                        yield f"{kind}/{called}/{key}"

    def __len__(self) -> int:
        return len(list(iter(self)))

    def items(self) -> Any:
        return [(target, self.value(target)[1]) for target in self]

    def _all(self, kind: str) -> list[int]:
        """The steps that made the objects of a kind."""
        made = [index for index, (function, _) in enumerate(self.steps)
                if self.KINDS.get(function) == kind]
        # There is one camera, the last.
        return made[-1:] if kind == "cameras" else made

    def _indices(self, kind: str, name: str) -> list[int]:
        """The steps that made the objects of a name, and the one of `#3`."""
        made = self._all(kind)
        found = [index for index in made if self.steps[index][1][0] == name]
        number = name[1:] if name.startswith("#") else ""
        if number.isascii() and number.isdecimal() and int(number) < len(made):
            return list(dict.fromkeys([*found, made[int(number)]]))
        return found

    def _number(self, kind: str, number: int) -> str:
        """A word for an index that is no name: `#3`, or else with zeros before it."""
        names = {self.steps[index][1][0] for index in self._all(kind)}
        return next(word for zeros in range(len(names) + 1)
                    if (word := f"#{'0' * zeros}{number}") not in names)

    def _find(self, target: str) -> tuple[int, list[str]]:
        """The step that made what an edit is about, and the way to the value in its keys."""
        kind, _, rest = target.partition("/")
        name, slash, path = rest.rpartition("/")
        kinds = list(dict.fromkeys(self.KINDS.values()))
        if not slash or not path:
            listed = ", ".join(kinds)
            raise SceneError(
                f"{target} is no edit\n  help: write KIND/NAME/KEY; kinds are {listed}"
            )
        if kind not in kinds:
            raise SceneError(
                f"{target}: `{kind}` is no kind of object\n  help: kinds are {', '.join(kinds)}"
            )
        found = self._indices(kind, name)
        made = self._all(kind)
        if len(found) > 1:
            called = [self._number(kind, made.index(index)) for index in found]
            raise SceneError(
                f"{target}: several {kind} are called so: {', '.join(called)}\n"
                f"  help: write {kind}/{called[0]}/..."
            )
        if not found:
            one = "medium" if kind == "media" else kind[:-1]
            names = [f"#{number} {self.steps[index][1][0]}" for number, index in enumerate(made)]
            remedy = f"the {kind} are {_some(names)}" if names else f"the scene has no {kind}"
            raise SceneError(f"{target}: no {one} is called `{name}`\n  help: {remedy}")
        return found[0], path.split(".")


class Editable:
    """What has values by name, KIND/NAME/KEY: a scene, or a world in the making."""

    __slots__ = ()

    def _source(self) -> Any:
        """What knows the values and the names, as `Parts` does."""
        raise NotImplementedError

    def _edit(self, edits: Mapping[str, Any], level: int) -> None:
        """Makes edits; warnings are of the line that is so many calls away."""
        raise NotImplementedError

    def _take_back(self, targets: list[str], level: int) -> bool:
        """Takes back the edits of places and of whole things; whether there were any."""
        raise NotImplementedError

    def _keys(self, path: str) -> list[str]:
        """The keys that an object may have."""
        raise NotImplementedError

    def __getitem__(self, target: str) -> Any:
        """A value, or, of a name or KIND/NAME, the `Object` whose attributes are the values.

        Lists are tuples and objects read-only mappings: what is to change is set.

        Raises:
            KeyError: if nothing states the value; it tells the default.
            SceneError: if there is no such thing, or several.
        """
        check_target(target)
        source = self._source()
        if target.count("/") < 2:
            return Object(self, source.objects(target))
        is_stated, value = source.value(target)
        if is_stated:
            return value
        default = source.default_of(target)
        words = f"by default {default}" if default else "and there is no default"
        raise KeyError(f"{target} is not stated, {words}")

    def get(self, target: str, default: Any = None) -> Any:
        """The value of a place, or another where nothing states it."""
        try:
            return self[target]
        except KeyError:
            return default

    def __contains__(self, target: object) -> bool:
        """Whether a value is stated: by the file, by what made the thing, or by an edit."""
        if not isinstance(target, str) or target.count("/") < 2:
            return False
        try:
            stated: bool = self._source().value(target)[0]
        except SceneError:
            return False
        return stated

    def __setitem__(self, target: str, value: Any) -> None:
        self._edit({target: value}, 3)

    def __delitem__(self, target: str) -> None:
        self._delete(target, 4)

    #: Without it Python would ask for numbers.
    __iter__ = None

    def edit(self, edits: Mapping[str, Any]) -> None:
        """Makes several edits at once, all or none: values by KIND/NAME/KEY.

        For values that only go together, or of which each would build the tree again. None takes a
        value away, as if nothing stated it. All are made before any is checked:

        >>> scene.edit({
        ...     "materials/plate/metal": None,
        ...     "materials/plate/eta": 0.2,
        ...     "materials/plate/k": 3.9,
        ... })

        Raises:
            SceneError: if there is no such thing, or several, or a value is not physical or not of
                the type that belongs there; then everything stays as it is.
            TypeError: if a thing that was made in code gets a value of another type; likewise.

        Warns:
            SceneWarning: of what is not rendered as it is described now, and was before.
        """
        self._edit(edits, 3)

    def reset(self, *targets: str) -> None:
        """Takes back edits at once: of places, of things by their name or KIND/NAME, or all.

        What the file says, or what the thing was made with, holds again.

        >>> scene.reset("plate", "cameras/eye/perspective.yfov")
        >>> scene.reset()                     # all of them

        Raises:
            SceneError: if there is no such thing, or what is left does not go together; then
                everything stays as it is.
        """
        for target in targets:
            check_target(target)
        source = self._source()
        self._take_back([path for target in targets or self.edits
                         for path in _places(source, target)], 3)

    @property
    def edits(self) -> dict[str, Any]:
        """The edits that count: values by KIND/NAME/KEY. `edit` makes them of another scene.

        What is within an edited value belongs to it, and of one place the last edit counts; None
        stands for what was taken away. It is a copy, of lists and dictionaries.
        """
        source = self._source()
        edits: dict[str, Any] = plain(source if isinstance(source, Parts) else source.edits())
        return edits

    def _delete(self, target: str, level: int) -> None:
        check_target(target)
        if not self._take_back(_places(self._source(), target), level):
            outer = next((edit for edit in self.edits if target.startswith(f"{edit}.")), None)
            where = f" by itself: take back {outer}" if outer else ""
            raise KeyError(f"{target} has not been edited{where}")


def _places(source: Any, target: str) -> list[str]:
    """What is meant by a place, or the name of things."""
    if target.count("/") < 2:
        things: list[str] = source.objects(target)
        return things
    return [target]


def check_target(target: object) -> None:
    """Refuses what is no name at all."""
    if not isinstance(target, str):
        raise TypeError(f"values are found by KIND/NAME/KEY, not by a {type(target).__name__}")


def values(edits: Mapping[str, Any]) -> dict[str, Any]:
    """Edits, with what is numpy's as plain numbers and lists."""
    if not isinstance(edits, Mapping):
        kind = type(edits).__name__
        raise TypeError(f"edits are a mapping, as {{'materials/glass/ior': 1.5}}, not a {kind}")
    for target in edits:
        check_target(target)
    return {target: plain(value, target) for target, value in edits.items()}


class Object:
    """Something in a scene, whose keys are attributes: what `scene["analyzer"]` is.

    >>> scene["analyzer"].axis_deg = 30
    >>> scene["camera"]["perspective.yfov"] = 0.5

    If several things have the name, that one is meant which may have the key. What is within a
    value has attributes too; what is not given raises an AttributeError.
    """

    __slots__ = ("_inner", "_paths", "_scene")

    _scene: Any
    _paths: list[str]
    _inner: str

    def __init__(self, scene: Any, paths: list[str], inner: str = "") -> None:
        object.__setattr__(self, "_scene", scene)
        object.__setattr__(self, "_paths", paths)
        object.__setattr__(self, "_inner", inner)

    def __getattr__(self, key: str) -> Any:
        if key.startswith("_"):
            raise AttributeError(key)
        try:
            return self[key]
        except KeyError as error:
            raise AttributeError(*error.args) from None
        except SceneError as error:
            # Whoever asks whether there is one gets an answer.
            if key in dir(self):
                raise
            raise AttributeError(str(error)) from None

    def __setattr__(self, key: str, value: Any) -> None:
        self._scene._edit({self._target(key): value}, 3)

    def __delattr__(self, key: str) -> None:
        self._scene._delete(self._target(key), 4)

    def __getitem__(self, key: str) -> Any:
        path = self._path(key)
        whole = self._inner + key
        keys = self._scene._keys(path)
        if whole not in keys and any(known.startswith(f"{whole}.") for known in keys):
            return Object(self._scene, [path], f"{whole}.")
        value = self._scene[f"{path}/{whole}"]
        return Object(self._scene, [path], f"{whole}.") if isinstance(value, Mapping) else value

    def __setitem__(self, key: str, value: Any) -> None:
        self._scene._edit({self._target(key): value}, 3)

    def __delitem__(self, key: str) -> None:
        self._scene._delete(self._target(key), 4)

    #: Without it Python would ask for numbers.
    __iter__ = None

    def __dir__(self) -> list[str]:
        keys = [key for path in self._paths for key in self._scene._keys(path)]
        inner = [key[len(self._inner):] for key in keys if key.startswith(self._inner)]
        return sorted({key.split(".")[0] for key in inner})

    def __repr__(self) -> str:
        inner = f"/{self._inner[:-1]}" if self._inner else ""
        return f"<{' or '.join(self._paths)}{inner} of {self._scene!r}>"

    def __reduce__(self) -> tuple[object, ...]:
        return Object, (self._scene, self._paths, self._inner)

    def _target(self, key: str) -> str:
        return f"{self._path(key)}/{self._inner}{key}"

    def _path(self, key: str) -> str:
        """Which of the things of the name is meant by a key."""
        if len(self._paths) == 1:
            return self._paths[0]
        first = (self._inner + key).split(".")[0]
        able = [
            path for path in self._paths
            if any(known.split(".")[0] == first for known in self._scene._keys(path))
        ]
        if len(able) == 1:
            return able[0]
        name = self._paths[0].partition("/")[2]
        raise SceneError(
            f"{name}: several things are called so: {', '.join(self._paths)}\n"
            f"  help: write scene[\"{self._paths[0]}\"]"
        )


#: Deepest nesting of values: what is deeper is likely to contain itself.
DEPTH_MAX = 64


def plain(value: Any, place: str = "a value", depth: int = 0) -> Any:
    """What is numpy's, or a mapping or sequence of any kind, as numbers, lists and dictionaries."""
    if value is None or isinstance(value, (bool, int, float, str, bytes)):
        # Without what others have made of these, as numpy's numbers are floats too.
        return value if type(value).__module__ == "builtins" else _number(value)
    if depth > DEPTH_MAX:
        raise SceneError(f"{place} is nested too deeply")
    if isinstance(value, np.generic):
        return _number(value)
    if isinstance(value, Mapping):
        return {str(key): plain(inner, place, depth + 1) for key, inner in value.items()}
    if hasattr(type(value), "__array__"):
        return _listed(np.asarray(value), place, depth)
    if isinstance(value, Sequence):
        return [plain(inner, place, depth + 1) for inner in value]
    return _number(value)


def _listed(array: Any, place: str, depth: int) -> Any:
    """Nested lists of an array."""
    if array.dtype.kind in "biu" or array.dtype in (np.float64, np.float32, np.float16):
        return array.tolist()
    if array.ndim == 0:
        return _number(array[()])
    return [plain(inner, place, depth + 1) for inner in array]


def _number(value: Any) -> Any:
    """A plain number, or word, if that is what it is."""
    if isinstance(value, np.bool_):
        return bool(value)
    if isinstance(value, (np.integer, numbers.Integral)):
        return int(value)
    if isinstance(value, (np.floating, numbers.Real)):
        return float(value)
    return str(value) if isinstance(value, str) else value


def _some(names: list[str]) -> str:
    """The first ten of a list, and how many more there are."""
    shown, more = names[:10], len(names) - 10
    return ", ".join([*shown, f"and {more} more"] if more > 0 else shown)


def _same(one: Any, other: Any) -> bool:
    """Whether two values are the same, as those are that come from one pickle."""
    if one is other:
        return True
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other)
    if isinstance(one, Mapping):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    if isinstance(one, (list, tuple)):
        return len(one) == len(other) and all(map(_same, one, other))
    return bool(one == other)


def _fixed(value: Any) -> Any:
    """A value that nobody changes by mistake: lists as tuples, dictionaries to be read only."""
    from types import MappingProxyType

    if isinstance(value, Mapping):
        return MappingProxyType({key: _fixed(inner) for key, inner in value.items()})
    if isinstance(value, (list, tuple)):
        return tuple(_fixed(inner) for inner in value)
    return value


def _with(value: Any, path: list[str], new: Any, target: str) -> Any:
    """A value with another further inwards; without it, if that is None."""
    if not path:
        return new
    key, *rest = path
    if isinstance(value, Mapping):
        inner = _with(value.get(key), rest, new, target)
        return {name: item for name, item in {**value, key: inner}.items() if item is not None}
    if isinstance(value, (list, tuple)):
        if not (key.isdecimal() and int(key) < len(value)):
            raise SceneError(
                f"{target}: `{key}` is no index into it\n"
                f"  help: its list has {len(value)} items, from 0 on"
            )
        if not rest and new is None:
            raise SceneError(
                f"{target} is an item of a list, and cannot be taken away\n"
                "  help: set the whole list"
            )
        items = list(value)
        items[int(key)] = _with(items[int(key)], rest, new, target)
        return items
    raise SceneError(f"{target}: there is no `{key}` in it\n  help: set the whole of it")


def _item(value: Any, key: str) -> Any:
    if isinstance(value, (list, tuple)) and key.isdecimal() and int(key) < len(value):
        return value[int(key)]
    return None


def _keys_of(step: tuple[str, tuple[Any, ...]]) -> dict[str, Any]:
    """The keys of a call, with what stands before them."""
    function, (_, *between, keys) = step
    leading = Parts.LEADING.get(function)
    return {**keys, leading: between[0]} if leading else dict(keys)


def _step_of(step: tuple[str, tuple[Any, ...]], keys: dict[str, Any]) -> Any:
    """The same call with other keys."""
    function, (name, *_) = step
    given = {key: value for key, value in keys.items() if value is not None}
    leading = Parts.LEADING.get(function)
    if leading is None:
        return function, (name, given)
    return function, (name, given.pop(leading, None), given)


def file_keys(path: str) -> list[str]:
    """The keys that an object of a file may have."""
    return _sunstone.keys_of(path.partition("/")[0])
