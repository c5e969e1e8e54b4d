"""Makes the pages of the library's headers and looks at them: doxygen must have nothing to warn of, every link must lead to
a page and a place on it, and every header that the examples include must have a page that names what is in it.

check_reference.py DOXYGEN DOXYFILE EXAMPLES"""
import html.parser
import pathlib
import re
import subprocess
import sys
import tempfile
import urllib.parse


# Doxygen 1.9.4 heads a page with links to its sections, also to the one of private classes, which it then leaves out.
OF_PRIVATE_CLASSES = "nested-classes"


class Page(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.links, self.places, self.words = set(), set(), ""
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("href", "src") and value:
                self.links.add(value)
            elif name in ("id", "name"):
                self.places.add(value)

    def handle_data(self, data):
        self.words += data


def broken_links(folder, pages):
    for name, page in pages.items():
        for link in page.links:
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = urllib.parse.unquote(parts.path) or name
            if not (folder / target).exists():
                yield f"{name}: {link}"
            elif parts.fragment in ("", OF_PRIVATE_CLASSES) or target not in pages:
                continue
            elif parts.fragment not in pages[target].places:
                yield f"{name}: {link}: no such place"


def headers_without_page(examples, pages):
    told = {match[1] for page in pages.values() if (match := re.search(r"(\S+\.h) File Reference", page.words))}
    # Where several headers have one name, doxygen titles them by as much of the path as tells them apart.
    for source in sorted(examples.glob("*.cpp")):
        for header in re.findall(r'#include "(roomwise/\S+)"', source.read_text()):
            if not any(("/" + header).endswith("/" + title) for title in told):
                yield f"{source.name}: {header}"


def main(doxygen, doxyfile, examples):
    with tempfile.TemporaryDirectory() as out:
        options = pathlib.Path(doxyfile).read_text() + f"\nOUTPUT_DIRECTORY = {out}\n"
        made = subprocess.run([doxygen, "-"], input=options, text=True, capture_output=True, check=False)
        assert made.returncode == 0 and not made.stderr, made.stderr
        folder = pathlib.Path(out) / "html"
        pages = {file.name: Page(file.read_text()) for file in folder.glob("*.html")}
        assert pages, "no pages were made"
        wrong = [*broken_links(folder, pages), *headers_without_page(pathlib.Path(examples), pages)]
    print(f"{len(pages)} pages")
    if wrong:
        sys.exit("these lead nowhere or have no page:\n" + "\n".join(wrong))


if __name__ == "__main__":
    main(*sys.argv[1:])
