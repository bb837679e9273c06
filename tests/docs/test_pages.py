"""The pages (README.md, docs/*.md) keep what they promise. `test_pages.py --words` prints the words of each.

- Figures: no commit hash; no table with a decimal figure, and no measured quantity in prose, outside what stands between
  `<!-- results: NAME/FILE -->` and `<!-- end -->`, which scripts/results fills.
- Reading: no sentence above 40 words; all pages together, with docs/site/, below 20,000, as `wc -w` counts what is not from
  scripts/results.
- Truth: links, anchors, pictures, paths of the tree, configuration keys and studies that a page names exist.
"""
import pathlib
import re
import subprocess
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
LINKED = [*PAGES, ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md"]
MOST_WORDS_OF_ALL = 20000
MOST_WORDS_OF_A_SENTENCE = 40

RESULTS = re.compile(r"(<!-- results: (?P<study>[\w-]+)/(?P<file>[\w.-]+(?:#1)?) -->\n).*?(<!-- end -->)", re.DOTALL)
CONSOLE = re.compile(r"(^```console\n)(.*?)(^```\n)", re.MULTILINE | re.DOTALL)
FENCED = re.compile(r"^```.*?^```\n", re.MULTILINE | re.DOTALL)
CODE = re.compile(r"`[^`]*`")
FOLDERS = "apps|bench|cmake|codecs|datasets|docs|estimation|eval|examples|filters|frontend|models|python|scripts|smoothers|tests"
OF_EXAMPLES = {"classifier.speed"}  # a key of examples/extension/
FAMILIES = "gate|classifier|labels|policy|motion|prior|frames|ekf|window"


def text_of(page):
    """A page without what scripts/results and scripts/tutorial put there."""
    def commands(block):
        return block[1] + "".join(line for line in block[2].splitlines(True) if line.startswith("$ ")) + block[3]

    return CONSOLE.sub(commands, RESULTS.sub(r"\1\4", page.read_text(encoding="utf-8")))


def blocks_of(text):
    """Lines of paragraphs, lists and cells of tables, by a plain reader of Markdown, who takes code for words and a list for a paragraph."""
    blocks, is_code, last = [[]], False, ""
    for line in re.sub(r"<!--.*?-->", "", FENCED.sub("\n", text)).splitlines():
        is_code = line.startswith("    ") and (is_code or not last.strip())
        last = line
        if is_code or not line.strip() or line.startswith(("#", "|")):
            cells = re.split(r"(?<!\\)\|", line) if line.startswith("|") else []
            blocks += [*([cell] for cell in cells), []]
        else:
            blocks[-1].append(line)
    return blocks


def items_of(text):
    """A list's items apart."""
    return re.split(r"\n\s*\n|\n(?=\s*(?:[-*]|\d+\.)\s)", "\n".join(line for block in blocks_of(text) for line in [*block, ""]))


def sentences_of(text):
    """Without code."""
    for item in items_of(text):
        plain = CODE.sub("CODE", item.replace("\n", " ")).replace("et al.", "et al")
        yield from re.split(r"(?<=[.!?])[\"')*_]*\s+(?=[A-Z*\[(\"0-9])", plain)


def long_sentences_of(text):
    """Of a reader who knows no end of a sentence but a stop and a space. Cells of tables are sentences."""
    for block in blocks_of(text):
        yield from too_long(r"(?<=[.!?])\s+", " ".join(block))
    for item in items_of(text):
        yield from too_long(r"(?<=[.!?])\s+(?=[A-Z])", item.replace("\n", " "))


def too_long(end, text):
    plain = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", text)
    return [s for s in re.split(end, plain) if words_of(s) > MOST_WORDS_OF_A_SENTENCE]


def words_of(text):
    """As `wc -w`."""
    return len(text.split())


def tables_of(text):
    """Of each table its heading and its rows."""
    lines = FENCED.sub("", text).splitlines()
    for i, line in enumerate(lines):
        if re.match(r"\|[-| :]+\|$", line) and i > 0:
            rows = []
            for row in lines[i + 1:]:
                if not row.startswith("|"):
                    break
                rows.append(row)
            yield lines[i - 1], rows


def slugs_of(page):
    """Anchors as GitHub makes them of headings."""
    slugs = set()
    for heading in re.findall(r"^#+ (.*)$", FENCED.sub("", page.read_text(encoding="utf-8")), re.MULTILINE):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "")
        slugs.add(re.sub(r"[^\w\- ]", "", plain.lower()).replace(" ", "-"))
    return slugs


def is_commit(word):
    done = subprocess.run(["git", "-C", ROOT, "cat-file", "-e", word + "^{commit}"], capture_output=True, check=False)
    return done.returncode == 0


class Pages(unittest.TestCase):
    def each(self, faults_of):
        """Of all pages, so that one run shows all faults."""
        faults = [f"{page.relative_to(ROOT)}: {fault}" for page in PAGES for fault in faults_of(page)]
        self.assertFalse(faults, "\n" + "\n".join(faults))


class Figures(Pages):
    def test_no_commit(self):
        def commits(page):
            for word in re.findall(r"\b[0-9a-f]{7,40}\b", text_of(page)):
                if (re.search("[0-9]", word) and re.search("[a-f]", word)) or is_commit(word):
                    yield f"{word} is a commit"

        self.each(commits)

    def test_no_table_of_figures(self):
        """Settings stand in code, formulas under a heading with [calc], thresholds under that word. (3.1), 2.1.1, table
        4.1 are places in the thesis."""
        place = re.compile(r"\(\d\.\d\)|\b\d\.\d\.\d\b|\b(tables?|figures?) \d\.\d[a-d]?|\(?\d\.\d[a-d]\)?")

        def measured(page):
            for heading, rows in tables_of(text_of(page)):
                if "[calc]" not in heading and "threshold" not in heading:
                    yield from (row for row in rows if re.search(r"\b\d+\.\d+", place.sub("", CODE.sub("", row))))

        self.each(measured)

    def test_no_measured_quantity_in_prose(self):
        """What a study finds has decimals and a unit. Settings stand in code; [calc] and "thesis" say where others are
        from."""
        quantity = re.compile(r"\b\d+\.\d+ ?(m|mm|cm|ms|s|deg|degrees|%|MB|frames/s)(?![\w/^])")
        self.each(lambda page: (s for s in sentences_of(text_of(page))
                                if quantity.search(s) and "[calc]" not in s and "thesis" not in s.lower()))

    def test_results_are_of_studies(self):
        def blocks(page):
            text = page.read_text(encoding="utf-8")
            if text.count("<!-- results:") != len(RESULTS.findall(text)):
                yield "a block of results does not end"
            for match in RESULTS.finditer(text):
                if not (ROOT / "eval/studies" / f"{match['study']}.yaml").exists():
                    yield f"results of {match['study']}, which is no study"

        self.each(blocks)


class Reading(Pages):
    def test_sentences(self):
        self.each(lambda page: (f"{words_of(s)} words: {s}" for s in long_sentences_of(text_of(page))))

    def test_words(self):
        pages = [*PAGES, *(ROOT / "docs/site").glob("*.md")]
        words = {str(page.relative_to(ROOT)): words_of(RESULTS.sub(r"\1\4", page.read_text(encoding="utf-8"))) for page in pages}
        print("words: " + ", ".join(f"{name} {n}" for name, n in words.items()) + f"; all {sum(words.values())}")
        self.assertLess(sum(words.values()), MOST_WORDS_OF_ALL)


class Truth(Pages):
    def test_links(self):
        faults = []
        for page in LINKED:
            text = CODE.sub("", FENCED.sub("", page.read_text(encoding="utf-8")))
            for target in re.findall(r"\]\(([\w./:#-]+)\)", text):
                if re.match(r"https?:", target):
                    continue
                name, _, anchor = target.partition("#")
                file = (page.parent / name).resolve() if name else page
                if not file.exists() or (anchor and anchor not in slugs_of(file)):
                    faults.append(f"{page.relative_to(ROOT)}: {target}")
        self.assertEqual(faults, [])

    def test_all_pages_are_listed(self):
        index = (ROOT / "docs/README.md").read_text(encoding="utf-8")
        missing = [page.name for page in PAGES[1:] if page.name != "README.md" and f"({page.name})" not in index]
        self.assertEqual(missing, [])

    def test_paths(self):
        def missing(page):
            for path in re.findall(rf"(?<![\w/.$:<-])((?:{FOLDERS})/[\w./-]*(?:\{{[\w,]+\}})?)", text_of(page)):
                alternatives = re.search(r"\{([\w,]+)\}$", path)
                stem = path[:alternatives.start()] if alternatives else path.rstrip(".")
                for end in alternatives[1].split(",") if alternatives else [""]:
                    if "NAME" not in path and not (ROOT / (stem + end)).exists():
                        yield stem + end

        self.each(missing)

    def test_keys(self):
        known = set(re.findall(r'"([\w.]+)"', (ROOT / "eval/configuration/configuration_keys.cpp").read_text(encoding="utf-8")))
        files = {".h", ".cpp", ".csv", ".md", ".yaml", ".json", ".py"}

        def unknown(page):
            for key in re.findall(rf"(?<![\w./])(?:{FAMILIES})\.[a-z][a-z_]*(?![\w.(])", text_of(page)):
                if pathlib.Path(key).suffix not in files and key not in known | OF_EXAMPLES:
                    yield f"{key} is no configuration key"

        self.each(unknown)

    def test_studies(self):
        studies = {file.stem for file in (ROOT / "eval/studies").glob("*.yaml")}
        named = re.compile(r"eval/studies/([a-z0-9_]+)\.yaml|scripts/results ([a-z0-9_]+)")
        self.each(lambda page: (f"no study {a or b}" for a, b in named.findall(text_of(page)) if (a or b) not in studies))


if __name__ == "__main__":
    if sys.argv[1:] == ["--words"]:
        sys.argv[1:] = ["Reading.test_words"]
    unittest.main()
