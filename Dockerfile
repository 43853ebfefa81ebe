# docker build -t arjuna .
# docker run --rm -it --name arjuna -p 127.0.0.1:8080:8080 arjuna sim
# docker exec -it arjuna arjuna nav --map maps/arjuna_room.yaml
# docker exec -it arjuna arjuna view --host 0.0.0.0

# What a checkout needs; the devcontainer is this stage.
FROM python:3.12-slim-bookworm AS tools
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install -y --no-install-recommends gcc g++ git libc6-dev libegl1 libgl1-mesa-dri make \
    && rm -rf /var/lib/apt/lists/*

FROM tools AS build
WORKDIR /arjuna
COPY . .
RUN make wheel EXTRAS=""

# The two wheels and what they depend on, without a compiler.
FROM python:3.12-slim-bookworm
# hadolint ignore=DL3008
RUN apt-get update \
    && apt-get install -y --no-install-recommends libegl1 libgl1-mesa-dri \
    && rm -rf /var/lib/apt/lists/*
COPY --from=build /arjuna/dist /wheels
# By their paths: the package index has a stranger called arjuna.
RUN pip install --no-cache-dir --find-links /wheels "/wheels/arjuna-0.1.0-py3-none-any.whl[ros]" \
    && useradd --create-home --uid 1000 robot
USER 1000
WORKDIR /home/robot
ENTRYPOINT ["arjuna"]
CMD ["--help"]
