// The files of a test program that has several: each lists its main function, by which the program runs it alone.
#ifndef QC_TESTS_SUPPORT_TEST_GROUP_H
#define QC_TESTS_SUPPORT_TEST_GROUP_H

struct qcTestFile
{
    const char* path;
    int (*run)();
    const qcTestFile* next;

    static inline const qcTestFile* first = nullptr;

    qcTestFile(const char* testPath, int (*testRun)()) : path(testPath), run(testRun), next(first)
    {
        first = this;
    }
};

// Files that are compiled together have numbers of their own.
#define QC_TEST_MAIN_NUMBER(number) QC_TEST_MAIN_NAMES(number)
#define QC_TEST_MAIN_NAMES(number)                                                                                     \
    static int qcRunFile##number();                                                                                    \
    static const qcTestFile qcFile##number(__FILE__, qcRunFile##number);                                               \
    static int qcRunFile##number()

#endif
