# docker build -t palpate . && docker run --rm -v "$PWD:/work" palpate run studies/first.yaml
# PyTorch's build without a GPU is smaller by gigabytes: --build-arg TORCH_INDEX=… as pytorch.org names it.
FROM debian:bookworm-slim
COPY .ci/packages.txt /tmp/packages.txt
RUN apt-get update \
 && apt-get install -y --no-install-recommends python3 python3-venv $(cat /tmp/packages.txt) \
 && rm -rf /var/lib/apt/lists/*
RUN python3 -m venv /opt/palpate
ENV PATH=/opt/palpate/bin:$PATH OMP_NUM_THREADS=1
ARG TORCH_INDEX=
RUN pip install --no-cache-dir ${TORCH_INDEX:+--index-url $TORCH_INDEX} "torch>=2.4,<2.14"
COPY . /opt/source
RUN pip install --no-cache-dir "/opt/source[learn,cad,viz,vision,cluster]" && palpate doctor
RUN useradd --create-home palpate
USER palpate
WORKDIR /work
ENTRYPOINT ["palpate"]
