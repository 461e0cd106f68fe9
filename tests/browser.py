"""Scripts of pages run as readers' browsers run them: by node where it is, by headless Chromium, or skipped."""

import html
import importlib.resources
import json
import re
import shutil
import subprocess

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
NODE = shutil.which("node")
QUIET = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--hide-scrollbars")


def asked(page, script, folder, width=1100):
    """What a script says of a page in headless Chromium, errors of the page's own scripts as `errors`; may wait."""
    if CHROMIUM is None:
        pytest.skip("no Chromium on this machine: pages are checked without a browser only")
    guard = "<script>window.errors=[];addEventListener('error',(e)=>errors.push(e.message))</script>"
    answer = f"Promise.resolve((async () => {{{script}}})()).catch((e) => e.stack)"
    probe = f"<script>{answer}.then((found) => parent.postMessage(JSON.stringify(found), '*'));</script>"
    probed = page.replace("<head>", f"<head>{guard}", 1).replace("</body>", f"{probe}</body>")
    (folder / "page.html").write_text(probed, encoding="utf-8")
    listen = "addEventListener('message', (e) => { document.getElementById('said').textContent = e.data; })"
    # A window of Chromium's is never narrower than 500: the page is asked inside a frame.
    frame = f'<iframe src="page.html" style="border:0;width:{width}px;height:900px"></iframe>'
    (folder / "frame.html").write_text(f'<!doctype html><pre id="said"></pre><script>{listen}</script>{frame}')
    where = [f"--user-data-dir={folder / 'profile'}", f"--window-size={width + 100},1000", "--virtual-time-budget=4000"]
    command = [CHROMIUM, *QUIET, *where, "--dump-dom", (folder / "frame.html").as_uri()]
    said = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    found = re.search(r'<pre id="said">(.+?)</pre>', said.stdout, re.DOTALL)
    assert found, said.stderr[-2000:]
    return json.loads(html.unescape(found[1]))


def evaluated(scripts, expression, data, folder):
    """Value of an expression of `data` after some scripts, by node or else by Chromium."""
    if NODE is None:
        tags = "".join(f"<script>{script}</script>" for script in scripts)
        stored = json.dumps(data).replace("<", "\\u003c")
        page = f"<!doctype html><html><head></head><body>{tags}</body></html>"
        return asked(page, f"const data = {stored}; return {expression};", folder)
    (folder / "data.json").write_text(json.dumps(data), encoding="utf-8")
    code = "\n".join([*scripts, f"const data = JSON.parse(require('fs').readFileSync({str(folder / 'data.json')!r}));"])
    (folder / "run.cjs").write_text(f"{code}\nconsole.log(JSON.stringify({expression}));", encoding="utf-8")
    said = subprocess.run([NODE, folder / "run.cjs"], capture_output=True, text=True, timeout=60, check=False)
    assert said.returncode == 0, said.stderr
    return json.loads(said.stdout)


def findings(page, folder, width=1100):
    """What axe-core finds wrong with a page whose folded parts are open: rule, how serious, and the first place."""
    axe = importlib.resources.files(pytest.importorskip("axe_core_python")) / "axe.min.js"
    probed = page.replace("</head>", f"<script>{axe.read_text(encoding='utf-8')}</script></head>", 1)
    script = """
      for (const folded of document.querySelectorAll("details")) folded.open = true;
      const { violations, passes } = await axe.run(document);
      if (passes.length < 20) throw new Error(`only ${passes.length} rules hold: the page was not looked at`);
      return violations.map(({ id, impact, nodes }) => [id, impact, nodes[0].html.slice(0, 200)]);"""
    return asked(probed, script, folder, width)
