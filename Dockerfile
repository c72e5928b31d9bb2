# SPDX-FileCopyrightText: 2026 The Sightline authors
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Debian 12 with the packages alone, for whoever does not want to build:
#   docker build -t sightline .
#   docker run --rm -v "$PWD:/data" sightline study boeing-table1 --out results
FROM debian:12 AS build
WORKDIR /sightline
RUN apt-get -qq update && apt-get -qq install -y --no-install-recommends git ca-certificates
COPY . .
RUN ./dev package

FROM debian:12-slim
COPY --from=build /sightline/build/package/packages/*.deb /tmp/
# Without gnuplot the report has no figures for print; everything else is there.
RUN apt-get -qq update \
    && apt-get -qq install -y --no-install-recommends \
       /tmp/sightline_*.deb /tmp/python3-sightline_*.deb \
    && rm -rf /tmp/*.deb /var/lib/apt/lists/* \
    && useradd --create-home sightline
USER sightline
WORKDIR /data
ENTRYPOINT ["sightline"]
CMD ["--help"]
