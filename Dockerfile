# A server for a group, see docs/howto/group-server.md: docker build -t corsmal .
FROM python:3.11-slim

# Chromium draws the figures of reports and downloads
RUN apt-get update \
    && apt-get install --yes --no-install-recommends chromium \
    && rm -rf /var/lib/apt/lists/*

# The address of PyTorch's packages for the CPU, from its page "Get started"; without it 5 GB for NVIDIA's GPUs are installed
ARG TORCH_INDEX=""
RUN if [ -n "$TORCH_INDEX" ]; then \
        pip install --no-cache-dir --index-url "$TORCH_INDEX" "torch==2.11.*" "torchvision==0.26.*" "torchaudio==2.11.*"; \
    fi

COPY . /src
RUN pip install --no-cache-dir "/src[app,train]" && rm -rf /src

RUN useradd --create-home corsmal && install --directory --owner=corsmal /cache /data
USER corsmal
ENV CORSMAL_CACHE=/cache STREAMLIT_SERVER_ADDRESS=0.0.0.0
VOLUME /cache
EXPOSE 8501
HEALTHCHECK CMD python -c "import urllib.request; urllib.request.urlopen('http://127.0.0.1:8501/_stcore/health')"
ENTRYPOINT ["corsmal", "app", "--no-browser", "--data-root", "/data"]
