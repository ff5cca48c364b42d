"""An interactive page in the browser whose pictures follow sliders; needs bokeh.

- `controls`: converts a scene to values of controls and back.
- `views`, `maps`: plain arrays that the pictures of an answer, and the map of regimes, show.
- `jobs`: computations that take seconds, in a process of their own.
- `pictures`: pictures that are created once and receive new numbers.
- `downloads`: files that the page offers.
- `page`: the page and its answers to requests of the browser.
- `serving`: the server, for this machine only.
"""
