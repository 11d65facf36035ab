"""One version: the manifest's."""

import re
import tomllib


def test_pyproject_and_changelog_name_the_manifests_version(project_root, manifest):
    project = tomllib.loads((project_root / "pyproject.toml").read_text("utf-8"))["project"]
    headings = re.findall(
        r"^## (\d+\.\d+\.\d+)\b", (project_root / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE
    )
    assert project["version"] == manifest["version"]
    assert headings[0] == manifest["version"], "the newest entry of CHANGELOG.md is of another version"
    assert headings == sorted(
        headings, key=lambda text: [int(part) for part in text.split(".")], reverse=True
    )


def test_blender_and_bpy_are_the_same_version(project_root, manifest):
    dependencies = tomllib.loads((project_root / "pyproject.toml").read_text("utf-8"))["project"][
        "dependencies"
    ]
    major_minor = ".".join(manifest["blender_version_min"].split(".")[:2])
    assert f"bpy=={major_minor}.*" in dependencies


def test_the_licence_is_the_manifests(project_root, manifest):
    assert manifest["license"] == ["SPDX:GPL-3.0-or-later"]
    text = (project_root / "LICENSE").read_text("utf-8")
    assert "GNU GENERAL PUBLIC LICENSE" in text
    assert "Version 3" in text
