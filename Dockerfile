# The package from its lock file:                       docker build -t vsb .
# A study of the current folder, results beside it:     docker run --rm -it --user "$(id -u):$(id -g)" -v "$PWD:/study" vsb run my_study.yaml
FROM python:3.11-slim-bookworm
WORKDIR /source
COPY requirements.lock ./
RUN python -m venv /opt/vsb \
 && /opt/vsb/bin/pip install --no-cache-dir --disable-pip-version-check -r requirements.lock
COPY . .
RUN /opt/vsb/bin/pip install --no-cache-dir --disable-pip-version-check --no-deps --no-build-isolation .
# HOME: Snakemake and matplotlib keep notes there, whoever runs the image; USER: Snakemake asks who that is, and nobody else knows.
ENV PATH=/opt/vsb/bin:$PATH \
    HOME=/tmp \
    USER=vsb \
    NUMBA_CACHE_DIR=/opt/vsb/compiled \
    OMP_NUM_THREADS=1 \
    OPENBLAS_NUM_THREADS=1
# A first study compiles the loops for all who run the image, and shows that it works.
WORKDIR /opt/first
RUN export HOME=/root \
 && vsb init first.yaml \
 && vsb run first.yaml \
 && chmod -R a+rwX /opt/vsb/compiled \
 && rm -rf /opt/first/* /opt/first/.snakemake
WORKDIR /study
ENTRYPOINT ["vsb"]
CMD ["--help"]
