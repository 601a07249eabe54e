"""MATLAB, HDF5, netCDF and Parquet files, read in a process of their own: libraries crash on damaged ones."""
