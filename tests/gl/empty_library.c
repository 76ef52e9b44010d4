// A GL library without a function.
void qcEmptyLibrary(void);

__attribute__((visibility("default"))) void qcEmptyLibrary(void)
{
}
