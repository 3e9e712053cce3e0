"""A scene as one HTML file that computes in a browser.

explore.py      explore: from a scene to its page. Start here.
inputs.py       what the page can change, and how far
page_file.py    the file: page/ with the model and the core in it
command.py      the command line
page/           HTML, CSS and JavaScript; uplot/: the library of its plots
"""
