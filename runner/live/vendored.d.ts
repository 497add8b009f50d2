// Scripts that stand before the modules on a page.
declare const uPlot: any;
