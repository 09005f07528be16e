"""The Bayes filter and its incarnations: one interface (`bayes`), one kind of problem (`models`), four beliefs.

    belief               module        prediction                   correction
    Gaussian, linear     kalman        mu <- F mu + B u             gain
                         scalar        one number, many runs        gain
    Gaussian, nonlinear  extended      Jacobians                    gain, by Jacobians
                         unscented     sigma points                 gain, by sigma points
    histogram            histogram     sum over the cells           product, cell by cell
    particles            particles     draw from the motion model   weights, then resampling

`corridor` and `range_bearing` are the two problems on which they are compared.
"""
