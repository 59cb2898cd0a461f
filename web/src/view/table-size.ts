/** Values of the table of R0 along each argument. */
export const TABLE_SIZE = 32;
