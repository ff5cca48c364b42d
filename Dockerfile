# slipfront with everything but compilers: the two commands of README run in it.
#
#     docker build --tag slipfront .
#     docker run --rm -v "$PWD/results:/slipfront/results" slipfront compare
#     docker run --rm --entrypoint sh slipfront -c "python -m pip install -e '.[test]' && python -m pytest"
#
# `explore` listens on 127.0.0.1 alone, also inside a container; run it with --network host.
FROM python:3.12-slim-bookworm

WORKDIR /slipfront
COPY meshes/apt-packages.txt meshes/
# git gives the version; the others are what gmsh links to
RUN apt-get update -qq \
 && apt-get install -y -qq --no-install-recommends git $(cat meshes/apt-packages.txt) \
 && rm -rf /var/lib/apt/lists/*

COPY . .
RUN python -m pip install --no-cache-dir '.[all]' \
 && useradd --create-home reader && mkdir -p results && chown -R reader /slipfront
USER reader
ENTRYPOINT ["slipfront"]
CMD ["--help"]
