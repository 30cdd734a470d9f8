"""The same equations written as others would: NumPy, Numba, SciPy, SUNDIALS, MuJoCo."""
