"""BVH and ASF/AMC read word by word and moved matrix by matrix: slow and obvious. Lawful files only; the file's own unit."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation


def move(parents, shifts, turns, root_positions):
    """World positions (frames, joints, 3) and orientations (frames, joints, 3, 3) of joints placed by their parents."""
    positions, orientations = [], []
    for f in range(len(root_positions)):
        where, turned = [], []
        for joint, parent in enumerate(parents):
            if parent < 0:
                where.append(np.array(root_positions[f], dtype=float))
                turned.append(turns[f][joint])
            else:
                where.append(where[parent] + turned[parent] @ np.array(shifts[f][joint], dtype=float))
                turned.append(turned[parent] @ turns[f][joint])
        positions.append(where)
        orientations.append(turned)
    return np.array(positions), np.array(orientations)


def read_bvh(text):
    """Names, world positions, world orientations, seconds between frames."""
    header, motion = text.split("MOTION\n")
    names, parents, offsets, channels = [], [], [], []
    stack = []
    for line in header.splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] in ("ROOT", "JOINT"):
            parents.append(stack[-1] if stack else -1)
            names.append(line.strip().split(None, 1)[1])
            offsets.append(None)
            channels.append([])
            opening = len(names) - 1
        elif words[0] == "End":
            opening = None
        elif words[0] == "{":
            stack.append(opening)
        elif words[0] == "}":
            stack.pop()
        elif words[0] == "OFFSET" and stack[-1] is not None:
            offsets[stack[-1]] = [float(w) for w in words[1:]]
        elif words[0] == "CHANNELS":
            channels[stack[-1]] = words[2:]
    lines = motion.splitlines()
    seconds = float(lines[1].split()[-1])
    shifts, turns, roots = [], [], []
    for line in lines[2:]:
        numbers = [float(w) for w in line.split()]
        shift, turn = [], []
        for joint in range(len(names)):
            where = list(offsets[joint])
            matrix = np.eye(3)
            for channel in channels[joint]:
                value = numbers.pop(0)
                axis = channel[0].lower()
                if channel.lower().endswith("position"):
                    where["xyz".index(axis)] = value
                else:
                    matrix = matrix @ Rotation.from_euler(axis, value, degrees=True).as_matrix()
            shift.append(where)
            turn.append(matrix)
        assert not numbers
        shifts.append(shift)
        turns.append(turn)
        roots.append(shift[0])
    positions, orientations = move(parents, shifts, turns, roots)
    return names, positions, orientations, seconds


def read_amc(asf, amc):
    """Names, world positions, world orientations; lengths as in the files, no unit applied."""
    radians = "angle rad" in asf
    bones = {"root": {"direction": np.zeros(3), "length": 0.0, "axis": np.eye(3), "dof": []}}
    parents = {"root": None}
    section, bone = None, None
    for line in asf.splitlines():
        words = line.replace("(", " ").replace(")", " ").split()
        if not words or words[0].startswith("#"):
            continue
        if words[0].startswith(":"):
            section = words[0]
        elif section == ":root" and words[0] == "order":
            bones["root"]["dof"] = [w.lower() for w in words[1:]]
        elif section == ":bonedata":
            if words[0] == "begin":
                bone = {"dof": [], "axis": np.eye(3)}
            elif words[0] == "name":
                bones[words[1]] = bone
            elif words[0] == "direction":
                bone["direction"] = np.array([float(w) for w in words[1:4]])
            elif words[0] == "length":
                bone["length"] = float(words[1])
            elif words[0] == "axis":
                for letter in words[4].lower():
                    angle = float(words[1 + "xyz".index(letter)])
                    # about fixed axes: later turns on the left
                    bone["axis"] = Rotation.from_euler(letter, angle, degrees=not radians).as_matrix() @ bone["axis"]
            elif words[0] == "dof":
                bone["dof"] = [w.lower() for w in words[1:]]
        elif section == ":hierarchy" and words[0] not in ("begin", "end"):
            for child in words[1:]:
                parents[child] = words[0]
    names = ["root"]
    while len(names) < len(parents):
        names += [n for n in parents if n not in names and parents[n] in names]

    shifts, turns, roots = [], [], []
    frame = None
    for line in amc.splitlines():
        words = line.split()
        if not words or words[0][0] in "#:":
            radians_here = ":RADIANS" in amc
            continue
        if len(words) == 1:
            frame = {n: (np.eye(3), np.zeros(3)) for n in names}
            turns.append(frame)
            continue
        bone = bones[words[0]]
        matrix, shift = np.eye(3), np.zeros(3)
        for dof, value in zip(bone["dof"], map(float, words[1:]), strict=True):
            if dof[0] == "t":
                shift["xyz".index(dof[1])] = value
            else:
                matrix = Rotation.from_euler(dof[1], value, degrees=not radians_here).as_matrix() @ matrix
        frame[words[0]] = (bone["axis"] @ matrix @ bone["axis"].T, bone["axis"] @ shift)
    for frame in turns:
        roots.append(frame["root"][1])
        shifts.append(
            [
                np.zeros(3)
                if parents[n] is None
                else bones[parents[n]]["direction"] * bones[parents[n]]["length"] + frame[n][1]
                for n in names
            ]
        )
    matrices = [[frame[n][0] for n in names] for frame in turns]
    indices = [-1 if parents[n] is None else names.index(parents[n]) for n in names]
    positions, orientations = move(indices, shifts, matrices, roots)
    return names, positions, orientations
