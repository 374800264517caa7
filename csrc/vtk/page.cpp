// page.cpp - lines, areas and words as a page of PDF, by libharu.
#include "window.h"

#ifdef YLM_WITH_HPDF

#include <hpdf.h>

#include <vector>

namespace {

struct Failure {
  HPDF_STATUS error = HPDF_OK;
};

void note(HPDF_STATUS error, HPDF_STATUS, void *user) {
  auto *failure = static_cast<Failure *>(user);
  if (failure->error == HPDF_OK) failure->error = error;
}

// Numbers of dashes are integers before libharu 2.4, floats since.
template <class Number, class Phase>
void set_dash(HPDF_STATUS (*set)(HPDF_Page, const Number *, HPDF_UINT, Phase), HPDF_Page page,
              int dash) {
  const Number dashed[] = {8, 5}, dotted[] = {2, 4};
  set(page, dash == 1 ? dashed : dash == 2 ? dotted : nullptr, dash ? 2 : 0, 0);
}

class Page {
public:
  Page(int width, int height) : height(height), document(HPDF_New(note, &failure)) {
    if (!document) return;
    HPDF_SetCompressionMode(document, HPDF_COMP_ALL);
    HPDF_UseUTFEncodings(document);
    page = HPDF_AddPage(document);
    HPDF_Page_SetWidth(page, float(width));
    HPDF_Page_SetHeight(page, float(height));
    HPDF_Page_SetLineCap(page, HPDF_ROUND_END);
    HPDF_Page_SetLineJoin(page, HPDF_ROUND_JOIN);
  }
  ~Page() {
    if (document) HPDF_Free(document);
  }
  Page(const Page &) = delete;
  Page &operator=(const Page &) = delete;

  void put(const ylm_vtk_mark &m) {
    set_opacity(float(m.colour[3]));
    if (m.text)
      put_words(m);
    else if (m.n)
      put_lines(m);
  }

  ylm_status save(const char *path, ylm_error *e) {
    if (!document) return ylm_fail(e, YLM_ENOMEM, "memory ran out for the page %s", path);
    if (failure.error == HPDF_OK) HPDF_SaveToStream(document);
    std::vector<HPDF_BYTE> bytes(failure.error == HPDF_OK ? HPDF_GetStreamSize(document) : 0);
    HPDF_UINT32 size = HPDF_UINT32(bytes.size());
    if (size) HPDF_ReadFromStream(document, bytes.data(), &size);
    if (failure.error == HPDF_FAILD_TO_ALLOC_MEM)
      return ylm_fail(e, YLM_ENOMEM, "memory ran out for the page %s", path);
    if (failure.error != HPDF_OK || size != bytes.size())
      return ylm_fail(e, YLM_EDEVICE, "%s: libharu fails with 0x%lx", path,
                      (unsigned long)failure.error);
    return ylm_file_save(path, bytes.data(), bytes.size(), e);
  }

private:
  Failure failure;
  const int height;
  HPDF_Doc document;
  HPDF_Page page = nullptr;
  HPDF_Font fonts[2] = {nullptr, nullptr};
  float opacity = 1;

  // Fonts are embedded; without one that has Greek letters there is Helvetica, which has none.
  HPDF_Font font(bool bold) {
    if (!fonts[bold]) {
      const char *file = ylm::font_file(bold);
      const char *name = file ? HPDF_LoadTTFontFromFile(document, file, HPDF_TRUE) : nullptr;
      fonts[bold] = name ? HPDF_GetFont(document, name, "UTF-8")
                         : HPDF_GetFont(document, bold ? "Helvetica-Bold" : "Helvetica", nullptr);
    }
    return fonts[bold];
  }

  void set_opacity(float alpha) {
    if (alpha == opacity) return;
    HPDF_ExtGState state = HPDF_CreateExtGState(document);
    HPDF_ExtGState_SetAlphaFill(state, alpha);
    HPDF_ExtGState_SetAlphaStroke(state, alpha);
    HPDF_Page_SetExtGState(page, state);
    opacity = alpha;
  }

  void put_words(const ylm_vtk_mark &m) {
    HPDF_Page_SetRGBFill(page, float(m.colour[0]), float(m.colour[1]), float(m.colour[2]));
    HPDF_Page_SetFontAndSize(page, font(m.bold != 0), float(m.size));
    HPDF_Page_BeginText(page);
    HPDF_Page_TextOut(page, float(m.xy[0]), float(height - m.xy[1]), m.text);
    HPDF_Page_EndText(page);
  }

  void put_lines(const ylm_vtk_mark &m) {
    set_dash(HPDF_Page_SetDash, page, m.dash);
    HPDF_Page_SetLineWidth(page, float(m.width));
    HPDF_Page_SetRGBStroke(page, float(m.colour[0]), float(m.colour[1]), float(m.colour[2]));
    HPDF_Page_SetRGBFill(page, float(m.colour[0]), float(m.colour[1]), float(m.colour[2]));
    HPDF_Page_MoveTo(page, float(m.xy[0]), float(height - m.xy[1]));
    for (size_t k = 1; k < m.n; k++)
      HPDF_Page_LineTo(page, float(m.xy[2 * k]), float(height - m.xy[2 * k + 1]));
    if (m.fill)
      HPDF_Page_Fill(page);
    else
      HPDF_Page_Stroke(page);
  }
};

} // namespace

extern "C" ylm_status ylm_vtk_save_pdf(const char *path, int width, int height, size_t n,
                                       const ylm_vtk_mark *marks, ylm_error *e) {
  return ylm::guarded(e, [&] {
    Page page(width, height);
    for (size_t i = 0; i < n; i++) page.put(marks[i]);
    return page.save(path, e);
  });
}

#else

extern "C" ylm_status ylm_vtk_save_pdf(const char *path, int, int, size_t, const ylm_vtk_mark *,
                                       ylm_error *e) {
  return ylm_fail(e, YLM_EMISSING, "%s: pages need libharu: install libhpdf-dev and run make again",
                  path);
}

#endif
