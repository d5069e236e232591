"""Parameters fitted to measured motions: how often they lie within their standard errors, and what a fit takes."""
