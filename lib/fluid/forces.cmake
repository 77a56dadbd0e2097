# The force schemes: one line per scheme, header in forces/ = type.
veriflex_types(fluid force
  first_order=FirstOrder
  guo=Guo
)
