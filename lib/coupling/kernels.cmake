# The delta kernels: one line per kernel, header in kernels/ = type.
veriflex_types(coupling kernel
  cosine=Cosine
  cosine_ball=CosineBall
  three_point=ThreePoint
  four_point=FourPoint
)
