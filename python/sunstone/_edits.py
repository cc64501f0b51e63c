"""Edits of scenes by name: `KIND/NAME/KEY`, or attributes of what a name means."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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

    def edited(self, edits: Mapping[str, Any]) -> Parts:
        """With other values; None is that of a key that is not given."""
        steps = list(self.steps)
        for target, value in edits.items():
            index, path = self._find(target)
            keys = _keys_of(steps[index])
            if len(path) > 1 and path[0] not in keys:
                raise SceneError(f"{target}: there is no `{path[0]}` in it\n  help: set the whole")
            keys[path[0]] = _with(keys.get(path[0]), path[1:], plain(value), target)
            steps[index] = _step_of(steps[index], keys)
        return Parts(self.name, self.base, steps)

    def taken_back(self, target: str) -> Parts | None:
        """With the value that there was before edits, if it is another."""
        index, (key, *_) = self._find(target)
        keys, before = _keys_of(self.steps[index]), _keys_of(self.base[index]).get(key)
        if _same(keys.get(key), before):
            return None
        steps = list(self.steps)
        steps[index] = _step_of(steps[index], {**keys, key: before})
        return Parts(self.name, self.base, steps)

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
            remedy = f"write KIND/NAME/KEY, or one of {', '.join(names)}"
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
                called = name if len(self._indices(kind, name)) == 1 else f"#{number}"
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
        """The steps that made the objects of a name, or the one of `#3`."""
        made = self._all(kind)
        found = [index for index in made if self.steps[index][1][0] == name]
        number = name[1:] if name.startswith("#") else ""
        if not found and number.isdecimal() and int(number) < len(made):
            return [made[int(number)]]
        return found

    def _find(self, target: str) -> tuple[int, list[str]]:
        """The step that made what an edit is about, and the way to the value in its keys."""
        kind, _, rest = target.partition("/")
        name, slash, path = rest.rpartition("/")
        kinds = list(dict.fromkeys(self.KINDS.values()))
        if not slash or not path:
            listed = ", ".join(kinds)
            raise SceneError(
                f"{target}: is no edit\n  help: write KIND/NAME/KEY; kinds are {listed}"
            )
        if kind not in kinds:
            raise SceneError(
                f"{target}: `{kind}` is no kind of object\n  help: kinds are {', '.join(kinds)}"
            )
        found = self._indices(kind, name)
        made = self._all(kind)
        if len(found) > 1:
            numbers = [f"#{made.index(index)}" for index in found]
            raise SceneError(
                f"{target}: several {kind} are called so: {', '.join(numbers)}\n"
                f"  help: write {kind}/{numbers[0]}/..."
            )
        if not found:
            one = "medium" if kind == "media" else kind[:-1]
            names = [f"#{number} {self.steps[index][1][0]}" for number, index in enumerate(made)]
            remedy = f"the {kind} are {', '.join(names)}" if names else f"the scene has no {kind}"
            raise SceneError(f"{target}: no {one} is called `{name}`\n  help: {remedy}")
        return found[0], path.split(".")


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
        self._scene._take_back(self._target(key), 3)

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
        self._scene._take_back(self._target(key), 3)

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


def plain(value: Any) -> Any:
    """What is numpy's, or a mapping or sequence of any kind, as numbers, lists and dictionaries."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in value.items()}
    if isinstance(value, Sequence) and not isinstance(value, (str, bytes)):
        return [plain(inner) for inner in value]
    return value


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
    """A value with another further inwards."""
    if not path:
        return new
    key, *rest = path
    if isinstance(value, Mapping):
        return {**value, key: _with(value.get(key), rest, new, target)}
    if isinstance(value, (list, tuple)):
        if not (key.isdecimal() and int(key) < len(value)):
            raise SceneError(
                f"{target}: `{key}` is no index into it\n"
                f"  help: its list has {len(value)} items, from 0 on"
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
