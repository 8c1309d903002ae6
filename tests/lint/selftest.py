#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Each lint rule is given a bad file, and must find it; and a good one, and must not."""
import subprocess
import tempfile
import unittest
from pathlib import Path

import format as format_rule
import hazards
import includes
import licences
import project
import sources
import symbols

HEAD = "// SPDX-License-Identifier: Apache-2.0\n"


class Planted(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)

    def findings(self, rule, path, text):
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
        found = rule.check(self.root)
        file.unlink()
        return found

    def caught(self, rule, path, text, word):
        found = self.findings(rule, path, text)
        self.assertTrue(any(word in finding for finding in found), f"{path}: {text!r} was not caught: {found}")

    def passes(self, rule, path, text):
        self.assertEqual(self.findings(rule, path, text), [])


class Hazards(Planted):
    HEADING = "| hazard | reaction | test |\n|---|---|---|\n"

    def test_a_hazard_names_a_test_that_is_there(self):
        tests = self.root / "tests/unit/a_test.cpp"
        tests.parent.mkdir(parents=True)
        tests.write_text("TEST_F(Guard, Shuts) {}\n", encoding="utf-8")
        self.passes(hazards, hazards.PAGE, f"{self.HEADING}| light | off | `Guard.Shuts` |\n")
        self.caught(hazards, hazards.PAGE, f"{self.HEADING}| light | off | `Guard.Opens` |\n", "Guard.Opens")
        self.caught(hazards, hazards.PAGE, f"{self.HEADING}| light | off | by hand |\n", "names no test")
        self.caught(hazards, hazards.PAGE, "no table\n", "no table")


class Includes(Planted):
    def test_each_layer_may_not_include_the_ones_above_it(self):
        for layer, above in (("shared", ("firmware", "boards", "host")), ("firmware", ("boards", "host")),
                             ("boards", ("host",)), ("host", ("firmware", "boards"))):
            for other in above:
                self.caught(includes, f"{layer}/x/a.cpp", f'{HEAD}#include "{other}/x/b.hpp"\n', f"{layer}/ must not")

    def test_each_layer_may_include_what_lies_below_it(self):
        for layer, below in includes.MAY_INCLUDE.items():
            for other in below:
                self.passes(includes, f"{layer}/x/a.cpp", f'{HEAD}#include "{other}/x/b.hpp"\n')

    def test_paths_start_at_the_root(self):
        self.caught(includes, "tests/unit/a.cpp", '#include "../host/a.hpp"\n', "without '..'")
        self.caught(includes, "shared/x/a.cpp", '# include "shared/../host/a.hpp"\n', "without '..'")
        self.caught(includes, "shared/x/a.cpp", '#include "b.hpp"\n', "from the project's root")

    def test_headers_that_allocate_or_do_io_are_banned_in_the_control_path(self):
        for layer in ("shared", "firmware"):
            for header in ("iostream", "vector", "string", "cmath", "functional", "mutex", "sys/socket.h"):
                self.caught(includes, f"{layer}/x/a.hpp", f"#include <{header}>\n", f"<{header}>")
            self.passes(includes, f"{layer}/x/a.hpp", "#include <string_view>\n#include <array>\n")
        self.passes(includes, "host/x/a.hpp", "#include <vector>\n")

    def test_words_are_banned_in_code_and_not_in_comments_or_literals(self):
        for text in ("int* p = new int;", "void* p = std::malloc(4);", "throw 1;", "auto* p = dynamic_cast<A*>(b);",
                     "void f(int* p) { delete p; }", "void f(int* p) { delete[] p; }"):
            self.caught(includes, "firmware/x/a.cpp", text + "\n", "firmware/")
        self.passes(includes, "firmware/x/a.cpp", '// new, throw\n/* malloc\n new */ auto a = "new"; int newer = 0;\n')
        self.passes(includes, "shared/x/a.hpp", "struct A { A(const A&) = delete; };\nconst int big = 1'000'000;\n")

    def test_machines_are_named_under_boards_only(self):
        text = "#ifdef STM32H743xx\n#endif\n"
        self.caught(includes, "firmware/x/a.cpp", text, "STM32H743xx")
        self.caught(includes, "shared/x/a.hpp", "#if defined(__ARM_ARCH)\n#endif\n", "__ARM_ARCH")
        self.passes(includes, "boards/stm32h743/a.cpp", text)


class Sources(Planted):
    def test_a_source_needs_its_licence_line(self):
        self.caught(sources, "host/x/a.cpp", "int a = 0;\n", "licence line")
        self.caught(sources, "tool", "#!/bin/sh\necho\n", "licence line")
        self.passes(sources, "host/x/a.cpp", HEAD)
        self.passes(sources, "tool", "#!/bin/sh\n# SPDX-License-Identifier: Apache-2.0\n")

    def test_a_long_file_is_refused(self):
        self.passes(sources, "host/x/a.cpp", HEAD + "\n" * 599)
        self.caught(sources, "host/x/a.cpp", HEAD + "\n" * 600, "601 lines")

    def test_paths_of_one_machine_are_found_in_any_text(self):
        for folder in ("work", "root", "home"):
            self.caught(sources, "docs/a.md", f"see `/{folder}/me/a.txt`\n", "path of one machine")
        self.passes(sources, "docs/a.md", "the frame/root of network/home/pages, ~/home/a\n")

    def test_form(self):
        self.caught(sources, "host/x/a.hpp", HEAD + "int a();\n", "#pragma once")
        self.caught(sources, "host/x/BadName.cpp", HEAD, "snake_case")
        self.caught(sources, "host/x/a.cpp", HEAD + "int a();", "no newline")
        self.caught(sources, "host/x/a.cpp", HEAD + "int a(); \n", "blanks")
        self.caught(sources, "host/x/a.cpp", HEAD + "\tint a();\n", "tab")
        self.caught(sources, "host/x/a.cpp", HEAD + "// FIX" + "ME later\n", "leftover")
        self.caught(sources, "host/x/a.cpp", HEAD + "int a();  // NO" + "LINT\n", "names its check")
        self.passes(sources, "host/x/a.cpp", HEAD + "int a();  // NO" + "LINT(some-check): the wire's type\n")


class Format(Planted):
    def test_misformatted_code_is_found_and_repaired(self):
        (self.root / ".clang-format").write_text((project.ROOT / ".clang-format").read_text())
        self.caught(format_rule, "host/x/a.cpp", HEAD + "int  a( ) ;\n", "clang-format")
        (self.root / "host/x/a.cpp").write_text(HEAD + "int  a( ) ;\n")
        self.assertEqual(format_rule.check(self.root, fix=True), [])
        self.assertEqual((self.root / "host/x/a.cpp").read_text(), HEAD + "int a();\n")


class Symbols(Planted):
    def archive(self, text):
        (self.root / "a.cpp").write_text(text)
        subprocess.run("g++ -std=c++23 -O0 -c a.cpp && rm -f a.a && ar rc a.a a.o", shell=True, cwd=self.root, check=True)
        return symbols.check([self.root / "a.a"])

    def test_what_the_control_path_may_not_need_is_found_in_the_object_code(self):
        for text, name in (("int* f() { return new int; }", "operator new"),
                           ("extern \"C\" double sin(double); double f(double a) { return sin(a); }", "'sin'"),
                           ("void f() { throw 1; }", "__cxa_throw"),
                           ("#include <cstdio>\nvoid f(int a) { std::printf(\"%d\", a); }", "printf"),
                           ("#include <vector>\nint f(std::vector<int>& a) { return a.at(1); }", "out_of_range")):
            self.assertTrue(any(name in finding for finding in self.archive(text)), name)

    def test_plain_code_needs_nothing(self):
        self.assertEqual(self.archive("double g(double); double f(double a) { return g(a) * __builtin_sqrt(2.0); }\n"
                                      "double g(double a) { return a; }"), [])


class Licences(unittest.TestCase):
    def test_a_gpl_library_is_found_by_its_name(self):
        for name in ("libceres.so.3", "libcholmod.so.3", "libCGAL.so.14"):
            self.assertTrue(licences.findings_in(f"\t{name} => /usr/lib/{name} (0x0)\n", "p"), name)
        self.assertEqual(licences.findings_in("\tlibsqlite3.so.0 => /usr/lib/libsqlite3.so.0 (0x0)\n", "p"), [])


if __name__ == "__main__":
    unittest.main()
