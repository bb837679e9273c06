# docker build -t slammot . && docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/data" slammot compare
FROM debian:bookworm AS build
RUN apt-get update && apt-get install --yes --no-install-recommends ca-certificates
COPY scripts/install-dependencies /source/scripts/
RUN /source/scripts/install-dependencies
COPY . /source
RUN cmake -S /source -B /build -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_PREFIX=/usr \
      -DSLAMMOT_BUILD_TESTS=OFF -DSLAMMOT_BUILD_BENCHMARKS=OFF \
 && cmake --build /build && cd /build && cpack -G DEB

FROM debian:bookworm
COPY --from=build /build/*.deb /tmp/
RUN apt-get update && apt-get install --yes --no-install-recommends /tmp/*.deb \
 && rm -rf /tmp/*.deb /var/lib/apt/lists/*
# Not root, so that root owns nothing that is written. `--user "$(id -u):$(id -g)"` writes as whoever calls.
RUN useradd --create-home slammot && install --directory --owner slammot /data
ENV MPLCONFIGDIR=/tmp/matplotlib
USER slammot
WORKDIR /data
ENTRYPOINT ["slammot"]
