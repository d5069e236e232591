"""Causal convolutions y_n = sum_(j<=n) w_(n-j) f_j of one signal with many kernels, by graded FFTs.

One FFT over the whole record leaves an error of eps times the LARGEST output in every output: with the weights of an
integral, which grow, the first samples would keep no digit. Outputs are therefore made in blocks [b/4, b), each by
an FFT that sees the first b samples only, so that the error in y_n is relative to what can be reached by time 4 t_n.
A circular transform of length 2b - b/4 suffices for such a block, as its wrap-around falls on outputs nobody reads;
the blocks together cost 7/6 of one padded transform.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from phichain.fractional.threads import product
from phichain.fractional.weights import triangular_toeplitz
from phichain.records import Held

Vector = NDArray[np.float64]

# Below this many samples the convolution is a product with a triangular Toeplitz matrix.
DIRECT = 128
GRADE = 4


@dataclass(frozen=True)
class _Block(Held):
    begin: int
    end: int
    length: int
    spectrum: NDArray[np.complex128]


@dataclass(frozen=True)
class Signal(Held):
    """A sampled signal with the transforms that every kernel shares.

    Attributes:
        samples: One row per channel, shape (C, n).
        head: Triangular Toeplitz matrices of the first samples, shape (C, H, H).
        blocks: The graded blocks behind the head.
    """

    samples: Vector
    head: Vector
    blocks: tuple[_Block, ...]


def transform(samples: Vector) -> Signal:
    """Prepare a signal, shape (C, n), for `convolve`."""
    size = samples.shape[1]
    head = min(size, DIRECT)
    toeplitz = np.stack([triangular_toeplitz(row[:head]) for row in samples])
    return Signal(samples, toeplitz, tuple(_block(samples, *bounds) for bounds in _bounds(size)))


def _bounds(size: int) -> list[tuple[int, int]]:
    bounds = []
    end = size
    while end > DIRECT:
        begin = max(DIRECT, end // GRADE)
        bounds.append((begin, end))
        end = begin
    return bounds[::-1]


def _block(samples: Vector, begin: int, end: int) -> _Block:
    # Lengths with a factor 16 are transformed fastest; 3^11 fits closer than 180000 and takes longer.
    length = 16 * fft.next_fast_len(-((begin + 1 - 2 * end) // 16), real=True)
    return _Block(begin, end, length, fft.rfft(samples[:, :end], length))


def convolve(signal: Signal, kernels: Vector) -> Vector:
    """sum_(j<=n) w_(n-j) f_j for every channel and kernel.

    Args:
        signal: The transformed signal, C channels of n samples.
        kernels: w, shape (A, n).

    Returns:
        Shape (C, A, n).
    """
    channels, size = signal.samples.shape
    result = np.empty((channels, kernels.shape[0], size))
    head = signal.head.shape[1]
    for channel in range(channels):
        product(kernels[:, :head], signal.head[channel], out=result[channel, :, :head])
    for block in signal.blocks:
        spectrum = fft.rfft(kernels[:, : block.end], block.length)
        for channel in range(channels):
            outputs = fft.irfft(spectrum * block.spectrum[channel], block.length, overwrite_x=True)
            result[channel, :, block.begin : block.end] = outputs[:, block.begin : block.end]
    return result


def convolve_short(signal: Signal, kernel: Vector) -> Vector:
    """The same for one kernel of a few taps, in floating-point sums free of transforms; shape (C, n)."""
    size = signal.samples.shape[1]
    return np.stack([np.convolve(row, kernel)[:size] for row in signal.samples])
