"""Causal convolutions y_n = sum_(j<=n) w_(n-j) f_j of one signal with many kernels, by graded and partitioned FFTs.

One FFT over the whole record leaves an error of eps times the LARGEST output in every output: with the weights of an
integral, which grow, the first samples would keep no digit. Outputs are therefore made in blocks [b/4, b), each by
an FFT that sees the first b samples only, so that the error in y_n is relative to what can be reached by time 4 t_n.
A circular transform of length 2b - b/4 suffices for such a block, as its wrap-around falls on outputs nobody reads;
the blocks together cost 7/6 of one padded transform.

Beyond `PIECE` samples the outputs come piece by piece instead (overlap-save, Stockham 1966): piece i of the outputs is
the sum over j of piece i - j of the signal with the kernel at lags (j - 1) PIECE .. (j + 1) PIECE, each a circular
transform of length 2 PIECE. The transforms stay in the cache, and what a kernel needs beside its own samples is two
numbers a sample, where one transform over all takes six.

Source: T. G. Stockham, High-speed convolution and correlation, AFIPS Spring Joint Computer Conference (1966) 229-233.
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
Spectra = NDArray[np.complex128]

# Below this many samples the convolution is a product with a triangular Toeplitz matrix.
DIRECT = 128
GRADE = 4
PIECE = 2**17
SCRATCH = 40
"""Bytes a sample of one kernel takes on its way, the kernel itself and its transforms; generously rounded."""


@dataclass(frozen=True)
class _Block(Held):
    begin: int
    end: int
    length: int
    spectrum: Spectra


@dataclass(frozen=True)
class Signal(Held):
    """A sampled signal with the transforms that every kernel shares.

    Attributes:
        samples: One row per channel, shape (C, n).
        head: Triangular Toeplitz matrices of the first samples, shape (C, H, H).
        blocks: The graded blocks behind the head, within the first piece.
        pieces: Transforms of the pieces, shape (C, pieces, PIECE + 1); none of a signal that has only one.
    """

    samples: Vector
    head: Vector
    blocks: tuple[_Block, ...]
    pieces: Spectra


def transform(samples: Vector) -> Signal:
    """Prepare a signal, shape (C, n), for `convolve`."""
    channels, size = samples.shape
    head = min(size, DIRECT)
    toeplitz = np.stack([triangular_toeplitz(row[:head]) for row in samples])
    blocks = tuple(_block(samples, *bounds) for bounds in _bounds(min(size, PIECE)))
    count = -(-size // PIECE) if size > PIECE else 0
    pieces = np.empty((channels, count, PIECE + 1), dtype=complex)
    for piece in range(count):
        pieces[:, piece] = fft.rfft(samples[:, piece * PIECE : (piece + 1) * PIECE], 2 * PIECE)
    return Signal(samples, toeplitz, blocks, pieces)


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


def convolve(signal: Signal, kernels: Vector, out: Vector) -> None:
    """sum_(j<=n) w_(n-j) f_j for every channel and kernel.

    Args:
        signal: The transformed signal, C channels of n samples.
        kernels: w, shape (A, n).
        out: Where the sums go, shape (C, A, n).
    """
    head = signal.head.shape[1]
    for channel, rows in enumerate(out):
        product(kernels[:, :head], signal.head[channel], out=rows[:, :head])
    for block in signal.blocks:
        spectrum = fft.rfft(kernels[:, : block.end], block.length)
        for channel, rows in enumerate(out):
            outputs = fft.irfft(spectrum * block.spectrum[channel], block.length, overwrite_x=True)
            rows[:, block.begin : block.end] = outputs[:, block.begin : block.end]
    if signal.pieces.shape[1]:
        for member, kernel in enumerate(kernels):
            _by_pieces(signal.pieces, kernel, out[:, member])


def _by_pieces(pieces: Spectra, kernel: Vector, out: Vector) -> None:
    """Set out[:, PIECE:] for one kernel, shapes (n,) and (C, n)."""
    count, size = pieces.shape[1], kernel.size
    lags = np.empty((count, PIECE + 1), dtype=complex)
    first = np.zeros(2 * PIECE)
    first[PIECE:] = kernel[:PIECE]
    lags[0] = fft.rfft(first)
    for j in range(1, count):
        lags[j] = fft.rfft(kernel[(j - 1) * PIECE : (j + 1) * PIECE], 2 * PIECE)
    total, term = np.empty((2, PIECE + 1), dtype=complex)
    for channel, row in enumerate(out):
        for i in range(1, count):
            total.fill(0)
            for j in range(i + 1):
                total += np.multiply(lags[j], pieces[channel, i - j], out=term)
            begin = i * PIECE
            row[begin : begin + PIECE] = fft.irfft(total, 2 * PIECE)[PIECE : PIECE + min(PIECE, size - begin)]


def convolve_short(signal: Signal, kernel: Vector) -> Vector:
    """The same for one kernel of a few taps, in floating-point sums free of transforms; shape (C, n)."""
    size = signal.samples.shape[1]
    return np.stack([np.convolve(row, kernel)[:size] for row in signal.samples])
