"""A trial: pieces of a march that advance together, behind one array interface.

- `interface`: what the loop asks of a batch of pieces, and the loop itself (`Batch`, `follow`).
- `compiled`, `compiled_passes`: a batch on processors, by the kernels of the program
  (`CompiledBatch`).
- `batch_transforms`: many convolutions in one plan of FFTW, two pieces to a complex array.
- `parts`: transforms and sweeps alone, for the times of parts.
- `grids`: the costly operations on whole grids, for numpy, or an array library on a GPU.
"""
